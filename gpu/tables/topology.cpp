#include "gpu/tables/topology.hpp"

#include <algorithm>
#include <tuple>

#include "gpu/search/loose_elements.hpp"

namespace collided {
namespace {

using Corners = std::array<uint32_t, 3>;

/// An element's vertices, and the triangle that it is held as.
const Corners& vertices_of(const Corners& triangle) { return triangle; }
const std::array<uint32_t, 2>& vertices_of(const std::array<uint32_t, 2>& edge) { return edge; }
std::array<uint32_t, 1> vertices_of(uint32_t point) { return {point}; }
Corners corners_of(const Corners& t) { return t; }
Corners corners_of(const std::array<uint32_t, 2>& e) { return {e[0], e[1], e[1]}; }
Corners corners_of(uint32_t p) { return {p, p, p}; }

/// Asks after a number of steps that take a bounded time together.
class Pace {
 public:
  explicit Pace(Asks& asks) : asks_(asks) {}
  void step() {
    if (--left_ > 0) return;
    left_ = kSteps;
    asks_.ask_if_due();
  }

 private:
  static constexpr uint32_t kSteps = 1 << 14;
  Asks& asks_;
  uint32_t left_ = kSteps;
};

template <size_t N>
bool has_vertex_twice(const std::array<uint32_t, N>& vertices) {
  for (size_t i = 0; i < N; ++i)
    for (size_t j = 0; j < i; ++j)
      if (vertices[i] == vertices[j]) return true;
  return false;
}

template <size_t N>
void check_vertices(const std::array<uint32_t, N>& vertices, uint32_t vertex_count, const auto& name_of_field) {
  for (const uint32_t v : vertices)
    if (v >= vertex_count)
      throw InvalidInput(name_of_field(), name_of_field() + " has vertex index " + std::to_string(v) +
                                              ", the mesh has " + std::to_string(vertex_count) + " vertices");
  if (!has_vertex_twice(vertices)) return;
  std::string list;
  for (const uint32_t v : vertices) list += ' ' + std::to_string(v);
  throw InvalidInput(name_of_field(), name_of_field() + " has a " + (N == 3 ? "corner" : "vertex") + " twice:" + list);
}

/// The elements of one kind that a mesh has.
template <class Elements>
void append_elements(FeatureTables& out, const Elements& elements, const MeshSpec& mesh, size_t index, const char* name,
                     Pace& pace) {
  for (size_t i = 0; i < elements.size(); ++i) {
    pace.step();
    check_vertices(vertices_of(elements[i]), mesh.vertex_count,
                   [&] { return "meshes[" + std::to_string(index) + "]." + name + "[" + std::to_string(i) + "]"; });
    Corners corners = corners_of(elements[i]);
    for (uint32_t& v : corners) v += out.topology.vertex_count;
    out.topology.triangles.push_back(corners);
  }
}

/// One without vertices and elements was removed.
void check_size(const Topology& topology, const MeshSpec& mesh, size_t index) {
  const std::string field = "meshes[" + std::to_string(index) + "]";
  if (mesh.vertex_count == 0 && count_elements(mesh) == 0) return;
  if (mesh.vertex_count == 0)
    throw InvalidInput(field + ".vertex_count", field + ".vertex_count is 0, at least 1 is needed");
  if (count_elements(mesh) == 0)
    throw InvalidInput(field + ".triangles", field + ".triangles is empty, and so are its edges and points");
  const uint64_t vertices = uint64_t{topology.vertex_count} + mesh.vertex_count;
  const uint64_t elements = topology.triangles.size() + count_elements(mesh);
  constexpr uint64_t kMax = kMaxFeatures;
  if (vertices > kMax || elements > kMax)
    throw InvalidInput("meshes",
                       "meshes have " + std::to_string(vertices) + " vertices and " + std::to_string(elements) +
                           " triangles, loose edges and points, the limit of each is " + std::to_string(kMax));
}

void append_mesh(FeatureTables& out, const MeshSpec& mesh, size_t index, Pace& pace) {
  Topology& topology = out.topology;
  check_size(topology, mesh, index);
  append_elements(out, mesh.triangles, mesh, index, "triangles", pace);
  append_elements(out, mesh.edges, mesh, index, "edges", pace);
  append_elements(out, mesh.points, mesh, index, "points", pace);
  topology.loose_edges += mesh.edges.size();
  topology.loose_points += mesh.points.size();
  topology.vertex_count += mesh.vertex_count;
  topology.vertex_offset.push_back(topology.vertex_count);
  topology.triangle_offset.push_back(static_cast<uint32_t>(topology.triangles.size()));
}

// The elements that are there, no more: tables that grow by doubling would hold twice as much.
void reserve(FeatureTables& out, const std::vector<MeshSpec>& meshes) {
  size_t elements = 0;
  for (const MeshSpec& mesh : meshes) elements += count_elements(mesh);
  out.topology.triangles.reserve(elements);
}

struct Use {
  std::array<uint32_t, 2> edge;
  uint32_t triangle, side;
};

size_t count_edges(const std::vector<Use>& sorted) {
  size_t count = 0;
  for (size_t i = 0; i < sorted.size(); ++i) count += i == 0 || sorted[i].edge != sorted[i - 1].edge;
  return count;
}

void number_edges(FeatureTables& out, Pace& pace) {
  const auto& triangles = out.topology.triangles;
  std::vector<Use> uses;
  uses.reserve(3 * triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    pace.step();
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
      if (a == b) continue;  // of a loose element
      uses.push_back({{std::min(a, b), std::max(a, b)}, i, k});
    }
  }
  std::sort(uses.begin(), uses.end(), [&](const Use& a, const Use& b) {
    pace.step();
    return std::tie(a.edge, a.triangle, a.side) < std::tie(b.edge, b.triangle, b.side);
  });
  out.triangle_edges.resize(triangles.size());
  out.topology.edges.reserve(count_edges(uses));
  for (const Use& use : uses) {
    pace.step();
    auto& edges = out.topology.edges;
    if (edges.empty() || edges.back() != use.edge) {
      edges.push_back(use.edge);
      out.owned[use.triangle] |= static_cast<uint8_t>(8u << use.side);  // lowest triangle comes first
    }
    out.triangle_edges[use.triangle][use.side] = static_cast<uint32_t>(edges.size() - 1);
  }
}

// Each vertex belongs to the lowest element that has it. Sorted by vertex, so that memory goes by the elements that
// came and not by the vertices that were declared.
void own_vertices(FeatureTables& out, Pace& pace) {
  const auto& triangles = out.topology.triangles;
  std::vector<uint64_t> corners;  // vertex, then place of the corner
  corners.reserve(3 * triangles.size());
  for (size_t i = 0; i < triangles.size(); ++i) {
    pace.step();
    for (size_t k = 0; k < 3; ++k) corners.push_back(uint64_t{triangles[i][k]} << 32 | (3 * i + k));
  }
  std::sort(corners.begin(), corners.end(), [&](uint64_t a, uint64_t b) {
    pace.step();
    return a < b;
  });
  uint64_t last = ~uint64_t{0};
  for (const uint64_t corner : corners) {
    pace.step();
    const uint32_t place = static_cast<uint32_t>(corner);
    if (corner >> 32 != last) out.owned[place / 3] |= static_cast<uint8_t>(1u << place % 3);
    last = corner >> 32;
  }
}

ElementRole role_of(const Corners& corners, uint32_t owned) {
  constexpr uint32_t kVertex = 1, kEdge = 8;
  if (corners[1] != corners[2]) return ElementRole::kTriangle;
  if (corners[0] != corners[1]) return owned & kEdge ? ElementRole::kLooseEdge : ElementRole::kDuplicate;
  return owned & kVertex ? ElementRole::kLoosePoint : ElementRole::kDuplicate;
}

void add_roles(FeatureTables& out) {
  for (size_t i = 0; i < out.owned.size(); ++i)
    out.owned[i] |=
        static_cast<uint8_t>(static_cast<uint32_t>(role_of(out.topology.triangles[i], out.owned[i])) << kRoleBit);
}

}  // namespace

FeatureTables make_features(const std::vector<MeshSpec>& meshes, Asks& asks) {
  if (meshes.empty()) throw InvalidInput("meshes", "meshes is empty, at least one is needed");
  Pace pace(asks);
  FeatureTables out;
  out.topology.vertex_offset.push_back(0);
  out.topology.triangle_offset.push_back(0);
  reserve(out, meshes);
  for (size_t i = 0; i < meshes.size(); ++i) append_mesh(out, meshes[i], i, pace);
  out.owned.assign(out.topology.triangles.size(), 0);
  own_vertices(out, pace);
  number_edges(out, pace);
  if (has_loose_elements(out.topology)) add_roles(out);
  return out;
}

std::vector<uint32_t> meshes_of_elements(const Topology& topology) {
  std::vector<uint32_t> meshes(topology.triangles.size());
  for (uint32_t mesh = 0; mesh + 1 < topology.triangle_offset.size(); ++mesh)
    std::fill(meshes.begin() + topology.triangle_offset[mesh], meshes.begin() + topology.triangle_offset[mesh + 1],
              mesh);
  return meshes;
}

}  // namespace collided
