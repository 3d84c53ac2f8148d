#include "gpu/step/touching_meshes.hpp"

namespace collided {
namespace {

/// The triangles of a mesh by their edges, which are told by their vertices.
class TrianglesAtEdges {
 public:
  explicit TrianglesAtEdges(const MeshOnHost& mesh) : mesh_(mesh) {
    for (uint32_t i = 0; i < mesh.triangles().size(); ++i)
      for (size_t k = 0; k < 3; ++k) at_.emplace(key(mesh.triangles()[i][k], mesh.triangles()[i][(k + 1) % 3]), i);
  }
  /// use(triangle) for each that has the edge of these scene-wide vertices, until it returns true. Returns that.
  template <class Use>
  bool any(const std::array<uint32_t, 2>& edge, const Use& use) const {
    const auto [first, last] = at_.equal_range(key(edge[0] - mesh_.first_vertex(), edge[1] - mesh_.first_vertex()));
    return std::any_of(first, last, [&](const auto& found) { return use(mesh_.triangles()[found.second]); });
  }

 private:
  static uint64_t key(uint32_t a, uint32_t b) { return pack_ids(std::min(a, b), std::max(a, b)); }

  const MeshOnHost& mesh_;
  std::unordered_multimap<uint64_t, uint32_t> at_;
};

}  // namespace

bool triangles_go_through(const SolidMeshes& meshes, const std::vector<EdgeAndTriangle>& ties, uint32_t first,
                          uint32_t second, const MeshOnHost& of_first, const MeshOnHost& of_second) {
  const TrianglesAtEdges at_first(of_first), at_second(of_second);
  const auto go_through = [&](const TrianglesAtEdges& at, const MeshOnHost& of_edge, const MeshOnHost& of_triangle,
                              uint32_t other, const EdgeAndTriangle& tie) {
    const uint32_t begin = meshes.topology->triangle_offset[other];
    Vec3<double> t[3], u[3];
    of_triangle.corners_of(of_triangle.triangles()[tie[1] - begin], t);
    return at.any(meshes.topology->edges[tie[0]], [&](const std::array<uint32_t, 3>& triangle) {
      of_edge.corners_of(triangle, u);
      return insides_cross(u, t);
    });
  };
  return std::any_of(ties.begin(), ties.end(), [&](const EdgeAndTriangle& tie) {
    const uint32_t mesh = meshes.mesh_of_edge(tie[0]), other = meshes.mesh_of_triangle(tie[1]);
    if (mesh == first && other == second) return go_through(at_first, of_first, of_second, other, tie);
    if (mesh == second && other == first) return go_through(at_second, of_second, of_first, other, tie);
    return false;
  });
}

}  // namespace collided
