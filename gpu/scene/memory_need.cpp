#include "gpu/scene/memory_need.hpp"

namespace collided {
namespace {

template <class T>
uint64_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

uint64_t max_making_bytes(uint64_t elements) {
  constexpr uint64_t kTables = 12 + 12 + 1 + 4;  // triangles, triangle_edges, owned, mesh_of_triangle
  constexpr uint64_t kUses = 3 * 16, kEdges = 3 * 8;
  return elements * (kTables + kUses + kEdges);
}

uint64_t bytes_of(const FeatureTables& features) {
  const Topology& topology = features.topology;
  return bytes_of(topology.triangles) + bytes_of(topology.edges) + bytes_of(features.triangle_edges) +
         bytes_of(features.owned) + bytes_of(features.mesh_of_triangle) + bytes_of(features.rings.begin) +
         bytes_of(features.rings.vertices);
}

}  // namespace collided
