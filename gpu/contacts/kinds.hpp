#pragma once
// The kinds of contacts: their stages, their order among each other, where their results go.

#include "gpu/contacts/contact.hpp"

namespace collided {

/// Kinds of features, by their place in the counters.
constexpr int kVertexTriangleKind = 0, kEdgeEdgeKind = 1;

template <class Kind>
struct KindTraits;
template <>
struct KindTraits<VertexTriangle> {
  static constexpr int kIndex = kVertexTriangleKind;
  static constexpr const char* kNarrow = "narrow_vt";
};
template <>
struct KindTraits<EdgeEdge> {
  static constexpr int kIndex = kEdgeEdgeKind;
  static constexpr const char* kNarrow = "narrow_ee";
};

/// Contacts of all kinds are sorted together, by the rank of their first feature: vertices, then edges, then triangles.
struct FeatureRanks {
  uint32_t first_edge, first_triangle, count;
};

}  // namespace collided
