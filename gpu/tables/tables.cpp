#include "gpu/tables/tables.hpp"

#include "gpu/contacts/kinds.hpp"

namespace collided {
namespace {

template <class T>
uint64_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

uint64_t bytes_of(const FeatureTables& features) {
  const Topology& topology = features.topology;
  return bytes_of(topology.triangles) + bytes_of(topology.edges) + bytes_of(features.triangle_edges) +
         bytes_of(features.owned) + bytes_of(features.rings.begin) + bytes_of(features.rings.vertices) +
         bytes_of(features.fans.begin) + bytes_of(features.fans.elements);
}

uint64_t elements_of(const SceneSpec& spec) {
  uint64_t elements = 0;
  for (const MeshSpec& mesh : spec.meshes) elements += count_elements(mesh);
  return elements;
}

/// That make_features() takes at most for so many elements, its result included.
uint64_t max_making_bytes(uint64_t elements) {
  constexpr uint64_t kTables = 12 + 12 + 1;  // triangles, triangle_edges, owned
  constexpr uint64_t kUses = 3 * 16, kEdges = 3 * 8;
  return elements * (kTables + kUses + kEdges);
}

}  // namespace

FeatureTables make_tables(const SceneSpec& spec, MemoryHold& making, Asks& asks) {
  making.resize(max_making_bytes(elements_of(spec)));
  FeatureTables features = make_features(spec.meshes, asks);
  making.resize(bytes_of(features));
  features.rings = make_rings(spec, features.topology, making, asks);
  if (tells_features(spec)) features.fans = make_fans(features.topology, making, asks);
  return features;
}

}  // namespace collided
