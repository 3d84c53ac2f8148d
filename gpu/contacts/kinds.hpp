#pragma once
// The kinds of contacts: their stages, and their order among each other.

#include "gpu/contacts/contact.hpp"

namespace collided {

template <class Kind>
struct KindTraits;
template <>
struct KindTraits<VertexTriangle> {
  static constexpr ContactKind kKind = ContactKind::kVertexTriangle;
  static constexpr const char* kNarrow = "narrow_vt";
};
template <>
struct KindTraits<EdgeEdge> {
  static constexpr ContactKind kKind = ContactKind::kEdgeEdge;
  static constexpr const char* kNarrow = "narrow_ee";
};

/// Where lists, counters and ranks of a kind are.
constexpr int index_of(ContactKind kind) { return static_cast<int>(kind); }
template <class Kind>
constexpr int kIndexOf = index_of(KindTraits<Kind>::kKind);

/// Contacts of all kinds are sorted together, by the rank of their first feature: those of the first kind, then those
/// of the second, and so on.
struct FeatureRanks {
  uint32_t begin[kContactKinds + 1];  ///< of each kind; at last their number

  COLLIDED_HD uint32_t count() const { return begin[kContactKinds]; }
  /// Rank of the first feature of the kind that the feature of this rank has.
  COLLIDED_HD uint32_t first_of_kind(uint32_t rank) const {
    uint32_t first = 0;
    for (size_t kind = 1; kind < kContactKinds; ++kind)
      if (rank >= begin[kind]) first = begin[kind];
    return first;
  }
};

/// Where the kinds begin in a sorted list.
struct KindBegins {
  uint64_t at[kContactKinds];
};

}  // namespace collided
