#include "gpu/scene/topology.hpp"

#include <algorithm>
#include <tuple>

namespace collided {
namespace {

void check_triangle(const std::array<uint32_t, 3>& t, uint32_t vertex_count, size_t mesh, size_t index) {
  const std::string field = "meshes[" + std::to_string(mesh) + "].triangles[" + std::to_string(index) + "]";
  for (const uint32_t v : t)
    if (v >= vertex_count)
      throw InvalidInput(field, field + " has vertex index " + std::to_string(v) + ", the mesh has " +
                                    std::to_string(vertex_count) + " vertices");
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
    throw InvalidInput(field, field + " has a corner twice: " + std::to_string(t[0]) + " " + std::to_string(t[1]) +
                                  " " + std::to_string(t[2]));
}

void append_mesh(FeatureTables& out, const MeshSpec& mesh, size_t index) {
  const std::string field = "meshes[" + std::to_string(index) + "]";
  const bool is_removed = mesh.vertex_count == 0 && mesh.triangles.empty();
  if (mesh.vertex_count == 0 && !is_removed)
    throw InvalidInput(field + ".vertex_count", field + ".vertex_count is 0, at least 3 are needed");
  if (mesh.triangles.empty() && !is_removed) throw InvalidInput(field + ".triangles", field + ".triangles is empty");
  Topology& topology = out.topology;
  const uint64_t vertices = uint64_t{topology.vertex_count} + mesh.vertex_count;
  const uint64_t triangles = topology.triangles.size() + mesh.triangles.size();
  constexpr uint64_t kMax = 1u << 29;  // edges, at most three a triangle, have 31 bits
  if (vertices > kMax || triangles > kMax)
    throw InvalidInput("meshes", "meshes have " + std::to_string(vertices) + " vertices and " +
                                     std::to_string(triangles) + " triangles, the limit of each is " +
                                     std::to_string(kMax));
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::array<uint32_t, 3> t = mesh.triangles[i];
    check_triangle(t, mesh.vertex_count, index, i);
    for (uint32_t& v : t) v += topology.vertex_count;
    topology.triangles.push_back(t);
    out.mesh_of_triangle.push_back(static_cast<uint32_t>(index));
  }
  topology.vertex_count = static_cast<uint32_t>(vertices);
  topology.vertex_offset.push_back(topology.vertex_count);
  topology.triangle_offset.push_back(static_cast<uint32_t>(triangles));
}

// The triangles that are there, no more: tables that grow by doubling would hold twice as much.
void reserve(FeatureTables& out, const std::vector<MeshSpec>& meshes) {
  size_t triangles = 0;
  for (const MeshSpec& mesh : meshes) triangles += mesh.triangles.size();
  out.topology.triangles.reserve(triangles);
  out.mesh_of_triangle.reserve(triangles);
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

void number_edges(FeatureTables& out) {
  const auto& triangles = out.topology.triangles;
  std::vector<Use> uses;
  uses.reserve(3 * triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
      uses.push_back({{std::min(a, b), std::max(a, b)}, i, k});
    }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    return std::tie(a.edge, a.triangle, a.side) < std::tie(b.edge, b.triangle, b.side);
  });
  out.triangle_edges.resize(triangles.size());
  out.topology.edges.reserve(count_edges(uses));
  for (const Use& use : uses) {
    auto& edges = out.topology.edges;
    if (edges.empty() || edges.back() != use.edge) {
      edges.push_back(use.edge);
      out.owned[use.triangle] |= static_cast<uint8_t>(8u << use.side);  // lowest triangle comes first
    }
    out.triangle_edges[use.triangle][use.side] = static_cast<uint32_t>(edges.size() - 1);
  }
}

// Each vertex belongs to the lowest triangle that has it. Sorted by vertex, so that memory goes by the triangles that
// came and not by the vertices that were declared.
void own_vertices(FeatureTables& out) {
  const auto& triangles = out.topology.triangles;
  std::vector<uint64_t> corners;  // vertex, then place of the corner
  corners.reserve(3 * triangles.size());
  for (size_t i = 0; i < triangles.size(); ++i)
    for (size_t k = 0; k < 3; ++k) corners.push_back(uint64_t{triangles[i][k]} << 32 | (3 * i + k));
  std::sort(corners.begin(), corners.end());
  uint64_t last = ~uint64_t{0};
  for (const uint64_t corner : corners) {
    const uint32_t place = static_cast<uint32_t>(corner);
    if (corner >> 32 != last) out.owned[place / 3] |= static_cast<uint8_t>(1u << place % 3);
    last = corner >> 32;
  }
}

}  // namespace

FeatureTables make_features(const std::vector<MeshSpec>& meshes) {
  if (meshes.empty()) throw InvalidInput("meshes", "meshes is empty, at least one is needed");
  FeatureTables out;
  out.topology.vertex_offset.push_back(0);
  out.topology.triangle_offset.push_back(0);
  reserve(out, meshes);
  for (size_t i = 0; i < meshes.size(); ++i) append_mesh(out, meshes[i], i);
  out.owned.assign(out.topology.triangles.size(), 0);
  own_vertices(out);
  number_edges(out);
  return out;
}

}  // namespace collided
