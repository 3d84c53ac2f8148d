#include "gpu/step/signed_distances.hpp"

#include <limits>

#include "gpu/base/keys.hpp"

namespace collided {
namespace {

/// A vertex, a triangle, or an edge by its vertices, and another mesh.
struct FeatureAndMesh {
  uint64_t feature;
  uint32_t mesh;

  bool operator<(const FeatureAndMesh& other) const {
    return feature != other.feature ? feature < other.feature : mesh < other.mesh;
  }
  bool operator==(const FeatureAndMesh&) const = default;
};

/// A set that is filled, then asked.
class FeaturesAndMeshes {
 public:
  void add(uint64_t feature, uint32_t mesh) { all_.push_back({feature, mesh}); }
  void finish() {
    std::sort(all_.begin(), all_.end());
    all_.erase(std::unique(all_.begin(), all_.end()), all_.end());
  }
  bool has(uint64_t feature, uint32_t mesh) const {
    return !all_.empty() && std::binary_search(all_.begin(), all_.end(), FeatureAndMesh{feature, mesh});
  }

 private:
  std::vector<FeatureAndMesh> all_;
};

/// A feature that has no point in common with a closed mesh lies on one side of it, as each of its vertices does.
class Signs {
 public:
  explicit Signs(const FoundInSolids& found) : meshes_(found.meshes), topology_(*found.meshes.topology) {
    for (size_t i = 0; i < found.inside.size(); ++i)
      inside_.add(found.inside.elements[i][0], meshes_.mesh_of_triangle(found.inside.elements[i][1]));
    for (const EdgeAndTriangle& ids : found.crossings.elements) add_meeting(ids);
    for (const EdgeAndTriangle& ids : found.ties) add_meeting(ids);
    inside_.finish(), edges_.finish(), triangles_.finish();
  }

  /// 1 or -1; 0 where there is none. Features that touch have no side.
  int of_vertex_triangle(const std::array<uint32_t, 2>& ids, bool touch) const {
    const uint32_t vertex = ids[0], triangle = ids[1], mesh = meshes_.mesh_of_vertex(vertex),
                   other = meshes_.mesh_of_triangle(triangle);
    if (!has_solid(mesh, other)) return 0;
    if (touch) return 1;
    if (meets(triangle, mesh)) return 0;
    return inside_.has(topology_.triangles[triangle][0], mesh) || inside_.has(vertex, other) ? -1 : 1;
  }
  int of_edge_edge(const std::array<uint32_t, 2>& ids, bool touch) const {
    const auto &a = topology_.edges[ids[0]], &b = topology_.edges[ids[1]];
    const uint32_t mesh = meshes_.mesh_of_edge(ids[0]), other = meshes_.mesh_of_edge(ids[1]);
    if (!has_solid(mesh, other)) return 0;
    if (touch) return 1;
    if (edges_.has(pack_ids(a[0], a[1]), other) || edges_.has(pack_ids(b[0], b[1]), mesh)) return 0;
    return inside_.has(a[0], other) || inside_.has(b[0], mesh) ? -1 : 1;
  }

 private:
  void add_meeting(const EdgeAndTriangle& ids) {
    const auto& edge = topology_.edges[ids[0]];
    edges_.add(pack_ids(edge[0], edge[1]), meshes_.mesh_of_triangle(ids[1]));
    triangles_.add(ids[1], meshes_.mesh_of_edge(ids[0]));
  }
  /// Of two meshes; a mesh and itself have no sign.
  bool has_solid(uint32_t mesh, uint32_t other) const {
    return mesh != other && (meshes_.are_solid[mesh] || meshes_.are_solid[other]);
  }
  bool meets(uint32_t triangle, uint32_t mesh) const {
    if (triangles_.has(triangle, mesh)) return true;
    const auto& t = topology_.triangles[triangle];
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      if (edges_.has(pack_ids(low, high), mesh)) return true;
    }
    return false;
  }

  const SolidMeshes& meshes_;
  const Topology& topology_;
  FeaturesAndMeshes inside_, edges_, triangles_;
};

/// sign(ids of both features, whether they touch): as in Signs.
template <class Sign>
void sign_set(CpuLoops& loops, ContactSet& set, const Sign& sign) {
  constexpr uint64_t kAtATime = 1u << 10;
  loops.for_each(set.signed_distance.size(), kAtATime, [&](uint64_t i) {
    const int found = sign(set.elements[i], set.distance[i] == 0);
    set.signed_distance[i] = found == 0 ? std::numeric_limits<double>::quiet_NaN() : found * set.distance[i];
    if (found < 0 && !set.normals.empty())
      for (float& x : set.normals[i]) x = -x;
  });
}

}  // namespace

void sign_distances(CpuLoops& loops, const FoundInSolids& found, PerKind<ContactSet>& contacts) {
  const Signs signs(found);
  sign_set(loops, contacts.vertex_triangle, [&](const auto&... of) { return signs.of_vertex_triangle(of...); });
  sign_set(loops, contacts.edge_edge, [&](const auto&... of) { return signs.of_edge_edge(of...); });
}

}  // namespace collided
