#include "gpu/scene/memory_need.hpp"

#include "gpu/positions/format.hpp"
#include "gpu/step/buffers.hpp"

namespace collided {
namespace {

template <class T>
uint64_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

// As SceneDetector allocates them.
template <class Real>
uint64_t min_device_bytes(const SceneSpec& spec, uint64_t vertices, uint64_t triangles) {
  const uint64_t tables = sizeof(Triangle) + sizeof(uint8_t) + (spec.kinds.edge_edge ? sizeof(Triangle) : 0);
  const uint64_t of_triangle = tables + sizeof(Box<float>) + sizeof(TriangleRecord<Real>);
  const uint64_t of_vertex = 2 * sizeof(Vec3<Real>);
  return vertices * of_vertex + triangles * of_triangle;
}

}  // namespace

uint64_t min_scene_bytes(const SceneSpec& spec, uint64_t vertices, uint64_t triangles) {
  const uint64_t on_host = triangles * sizeof(std::array<uint32_t, 3>);
  const uint64_t on_device =
      with_real(spec.scalar, [&]<class Real>(Real) { return min_device_bytes<Real>(spec, vertices, triangles); });
  return on_host + on_device;
}

uint64_t max_making_bytes(uint64_t triangles) {
  constexpr uint64_t kTables = 12 + 12 + 1 + 4;  // triangles, triangle_edges, owned, mesh_of_triangle
  constexpr uint64_t kUses = 3 * 16, kEdges = 3 * 8;
  return triangles * (kTables + kUses + kEdges);
}

uint64_t bytes_of(const FeatureTables& features) {
  const Topology& topology = features.topology;
  return bytes_of(topology.triangles) + bytes_of(topology.edges) + bytes_of(features.triangle_edges) +
         bytes_of(features.owned) + bytes_of(features.mesh_of_triangle) + bytes_of(features.rings.begin) +
         bytes_of(features.rings.vertices);
}

}  // namespace collided
