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

  /// Rank of the first feature of the kind that the feature of this rank has.
  COLLIDED_HD uint32_t first_of_kind(uint32_t rank) const {
    return rank >= first_triangle ? first_triangle : rank >= first_edge ? first_edge : 0;
  }
};

/// Where the kinds begin in a sorted list.
struct KindBegins {
  uint64_t edges, triangles;
};

}  // namespace collided
