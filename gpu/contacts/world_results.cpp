#include "gpu/contacts/world_results.hpp"

namespace collided {
namespace {

/// How many features of a kind each world has.
struct FeaturesOfWorld {
  uint32_t first, second;
};
FeaturesOfWorld features_of(ContactKind kind, const WorldShape& shape) {
  switch (kind) {
    case ContactKind::kVertexTriangle:
    case ContactKind::kVertexSolid:
      return {shape.vertices, shape.triangles};
    case ContactKind::kEdgeEdge:
      return {shape.edges, shape.edges};
    case ContactKind::kTriangleTriangle:
      return {shape.triangles, shape.triangles};
    case ContactKind::kEdgeTriangle:
      break;
  }
  return {shape.edges, shape.triangles};
}

/// Contacts are in the order of their first ids, and so of their worlds.
std::vector<uint64_t> divide(const FeaturesOfWorld& features, uint32_t worlds, ContactSet& set) {
  std::vector<uint64_t> begin;
  begin.reserve(uint64_t{worlds} + 1);
  uint64_t i = 0;
  for (uint32_t world = 0; world < worlds; ++world) {
    begin.push_back(i);
    const uint32_t first = world * features.first, second = world * features.second;
    for (; i < set.size() && set.elements[i][0] - first < features.first; ++i) {
      set.elements[i][0] -= first;
      set.elements[i][1] -= second;
    }
  }
  begin.push_back(i);
  return begin;
}

}  // namespace

WorldResults divide_by_world(const WorldShape& shape, PerKind<ContactSet>& contacts) {
  WorldResults results;
  for_each_kind([&](ContactKind kind, ContactSet& set,
                    std::vector<uint64_t>& begin) { begin = divide(features_of(kind, shape), shape.worlds, set); },
                contacts, results.begin);
  return results;
}

}  // namespace collided
