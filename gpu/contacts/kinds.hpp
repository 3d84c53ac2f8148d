#pragma once
// The kinds of contacts: their features, their stages, and their order among each other.

#include "gpu/base/keys.hpp"
#include "gpu/base/worlds.hpp"
#include "gpu/contacts/contact.hpp"

namespace collided {

/// Where lists, counters and ranks of a kind are.
constexpr int index_of(ContactKind kind) { return static_cast<int>(kind); }
template <class Kind>
constexpr int kIndexOf = index_of(Kind::kKind);

struct VertexTriangle {
  static constexpr ContactKind kKind = ContactKind::kVertexTriangle;
  static constexpr const char* kNarrow = "narrow_vt";  ///< its stage

  WorldTable<Vec3<uint32_t>> triangles;

  COLLIDED_HD bool has(uint64_t key) const { return static_cast<uint32_t>(key) < triangles.size(); }
  COLLIDED_HD Stencil stencil(uint64_t key) const {
    const Vec3<uint32_t> t = triangles[static_cast<uint32_t>(key)];
    return {{static_cast<uint32_t>(key >> 32), t.x, t.y, t.z}};
  }
};

struct EdgePair {
  uint32_t from, to;
};
COLLIDED_HD inline EdgePair with_ids_moved(const EdgePair& edge, uint32_t by) { return {edge.from + by, edge.to + by}; }

struct EdgeEdge {
  static constexpr ContactKind kKind = ContactKind::kEdgeEdge;
  static constexpr const char* kNarrow = "narrow_ee";

  WorldTable<EdgePair> edges;

  COLLIDED_HD bool has(uint64_t key) const {
    return (key >> 32) < edges.size() && static_cast<uint32_t>(key) < edges.size();
  }
  COLLIDED_HD Stencil stencil(uint64_t key) const {
    const EdgePair a = edges[key >> 32], b = edges[static_cast<uint32_t>(key)];
    return {{a.from, a.to, b.from, b.to}};
  }
};

/// Kinds whose candidates are four vertices, for the narrow phase to decide: the first of all kinds.
constexpr int kFeatureKinds = 2;
constexpr bool is_of_features(ContactKind kind) { return index_of(kind) < kFeatureKinds; }

/// Whether contacts of these kinds have edges.
constexpr bool have_edges(const PerKind<bool>& kinds) { return kinds.edge_edge || kinds.edge_triangle; }

/// Whether frames of DCD name the features that closest points are on. A scene on several devices names none, because
/// each device knows a part of the contacts alone.
inline bool tells_features(const SceneSpec& spec) {
  return spec.fields.has(ContactField::kFeatures) && spec.mode != Mode::kCcd && spec.part_devices.empty() &&
         (spec.kinds.vertex_triangle || spec.kinds.edge_edge);
}
/// Whether frames of DCD tell signed distances, which only solids give a sign.
inline bool tells_signed_distances(const SceneSpec& spec) {
  return spec.fields.has(ContactField::kSignedDistance) && spec.mode != Mode::kCcd && has_solids(spec) &&
         (spec.kinds.vertex_triangle || spec.kinds.edge_edge);
}
/// Whether frames of DCD ask what is in which solid.
inline bool looks_into_solids(const SceneSpec& spec) {
  return spec.kinds.vertex_solid || spec.pair_states || tells_signed_distances(spec);
}
/// The kinds that a scene's steps look for. Which contacts are covered, how meshes lie to each other and where
/// distances have no sign depends on what crosses. Vertices in solids are found after the step.
inline PerKind<bool> kinds_looked_for(const SceneSpec& spec) {
  PerKind<bool> kinds = spec.kinds;
  kinds.vertex_solid = false;
  kinds.edge_triangle = kinds.edge_triangle || tells_features(spec) || spec.pair_states || tells_signed_distances(spec);
  return kinds;
}

/// The kinds of features, on the tables of a scene.
struct FeatureKinds {
  VertexTriangle vertex_triangle;
  EdgeEdge edge_edge;

  template <class Tables>
  static FeatureKinds of(const Tables& tables) {
    return {{tables.corners()}, {tables.edge_ends()}};
  }
  /// visit(kind) for each in order.
  template <class Visit>
  void for_each(const Visit& visit) const {
    visit(vertex_triangle);
    visit(edge_edge);
  }
  /// use(kind) for the one of this index, if it is one of these.
  template <class Use>
  COLLIDED_HD void use_one(int index, const Use& use) const {
    if (index == kIndexOf<VertexTriangle>) use(vertex_triangle);
    if (index == kIndexOf<EdgeEdge>) use(edge_edge);
  }
};

/// The first of the kinds that are wanted; there must be one.
constexpr ContactKind first_of(const PerKind<bool>& wanted) {
  ContactKind first = {};
  bool is_found = false;
  for_each_kind(
      [&](ContactKind kind, bool is_wanted) {
        if (is_wanted && !is_found) first = kind, is_found = true;
      },
      wanted);
  return first;
}

/// Contacts of all kinds are sorted together, by the rank of their first feature: those of the first kind, then those
/// of the second, and so on.
struct FeatureRanks {
  uint32_t begin[kContactKinds + 1];  ///< of each kind; at last their number

  COLLIDED_HD uint32_t count() const { return begin[kContactKinds]; }
  /// Index of the kind that the feature of this rank is of.
  COLLIDED_HD int kind_of(uint32_t rank) const {
    int found = 0;
    for (int kind = 1; kind < static_cast<int>(kContactKinds); ++kind)
      if (rank >= begin[kind]) found = kind;
    return found;
  }
  /// How many first features the kind with the most of them has.
  COLLIDED_HD uint32_t most_of_a_kind() const {
    uint32_t most = 0;
    for (size_t kind = 0; kind < kContactKinds; ++kind) {
      const uint32_t count = begin[kind + 1] - begin[kind];
      most = count > most ? count : most;
    }
    return most;
  }
  /// Rank of the first feature of the same kind.
  COLLIDED_HD uint32_t first_of_kind(uint32_t rank) const { return begin[kind_of(rank)]; }
};

/// use(kind, key) for a contact's key, where it is of features; the key that it gets counts those of its kind alone.
template <class Use>
COLLIDED_HD void use_contact(const FeatureKinds& kinds, const FeatureRanks& ranks, uint64_t key, const Use& use) {
  const uint32_t rank = first_id(key);
  const uint64_t own = pack_ids(rank - ranks.first_of_kind(rank), second_id(key));
  kinds.use_one(ranks.kind_of(rank), [&](const auto& kind) { use(kind, own); });
}

/// Where the kinds begin in a sorted list.
struct KindBegins {
  uint64_t at[kContactKinds];
};

}  // namespace collided
