#pragma once
// Marks the contacts of a frame that others cover: a surface comes clearly nearer beside their closest points, or an
// earlier contact is between the same two features. The rest has each local minimum of the distance once. It works on
// columns in the order of the answer.
//
// Two meshes that cross have their minimum at the crossing, and no contact of features lies there. So a surface that
// comes nearer covers nothing of theirs. One crossing that is more than a touch tells that they cross.

#include "gpu/base/deviations.hpp"
#include "gpu/base/key_set.hpp"
#include "gpu/contacts/columns.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/narrow/closest_features.hpp"
#include "gpu/narrow/surfaces.hpp"

namespace collided {

/// Of features that only exact arithmetic can tell; no answer has the mark.
constexpr uint8_t kFeaturesOpen = 128;

/// For each key the first contact that has it: open addressing in a power of two of slots, half of them or more free.
/// Many threads fill it at once, and what it says does not depend on their order.
struct FirstPlaces {
  static constexpr uint32_t kNone = ~0u;

  Span<const uint64_t> keys;  ///< of each contact
  Span<uint32_t> slots;       ///< kNone: free

  /// Slots for so many contacts.
  COLLIDED_HD static uint64_t slots_for(uint64_t contacts) {
    uint64_t count = 2;
    while (count < 2 * contacts) count *= 2;
    return count;
  }
  /// Of so many contacts alone, whose slots are the first ones.
  COLLIDED_HD FirstPlaces of(uint64_t contacts) const { return {keys, {slots.data, slots_for(contacts)}}; }
  COLLIDED_HD void add(uint32_t place) const {
    const uint64_t key = keys[place], last = slots.size() - 1;
    for (uint64_t slot = mixed_key(key) & last;; slot = (slot + 1) & last) {
      const uint32_t there = atomic_claim(slots[slot], kNone, place);
      if (there == kNone) return;
      if (keys[there] == key) return atomic_min(slots[slot], place);
    }
  }
  COLLIDED_HD uint32_t find(uint64_t key) const {
    const uint64_t last = slots.size() - 1;
    for (uint64_t slot = mixed_key(key) & last;; slot = (slot + 1) & last)
      if (slots[slot] == kNone || keys[slots[slot]] == key) return slots[slot];
  }
};

/// The contacts of a frame, in order.
struct OrderedContacts {
  ContactColumns columns;
  Counted count;
  const KindBegins* kinds;
  FeatureKinds features;  ///< with the tables of all edges and elements
  WorldTable<Vec3<uint32_t>> sides;
  MeshesOfVertices meshes;
  uint64_t vertices;  ///< of the scene

  COLLIDED_HD const WorldTable<EdgePair>& edges() const { return features.edge_edge.edges; }
  COLLIDED_HD const WorldTable<Vec3<uint32_t>>& corners() const { return features.vertex_triangle.triangles; }
  COLLIDED_HD int kind_of(uint64_t i) const {
    int found = 0;
    for (int kind = 1; kind < static_cast<int>(kContactKinds); ++kind)
      if (i >= kinds->at[kind]) found = kind;
    return found;
  }
  COLLIDED_HD uint64_t key_of(uint64_t i) const {
    const uint32_t* ids = reinterpret_cast<const uint32_t*>(columns.elements.data + i);
    return pack_ids(ids[0], ids[1]);
  }
  /// use(kind, key) of a contact of features. A step that was short of room, and runs again, may have left ids that
  /// nobody wrote.
  template <class Use>
  COLLIDED_HD void use_features(uint64_t i, const Use& use) const {
    features.use_one(kind_of(i), [&]<class Kind>(const Kind& kind) {
      const uint64_t key = key_of(i);
      if (kind.has(key) && (Kind::kKind != ContactKind::kVertexTriangle || first_id(key) < vertices)) use(kind, key);
    });
  }
  COLLIDED_HD bool is_sure_crossing(uint64_t i) const {
    const uint8_t flags = columns.flags[i];
    return kind_of(i) == static_cast<int>(ContactKind::kEdgeTriangle) && (flags & kFlagCertified) != 0 &&
           (flags & kFlagTouching) == 0 && first_id(key_of(i)) < edges().size() &&
           second_id(key_of(i)) < corners().size();
  }

  // Keys of pairs of features, and of meshes: ids of features, counted through all corners, sides and faces, are below
  // those of meshes.
  COLLIDED_HD uint64_t key_of_features(const VertexTriangle& kind, uint64_t key, uint8_t bits) const {
    const uint32_t element = second_id(key);
    const Stencil s = kind.stencil(key);
    const int at = bits & kOfTriangle;
    if (at == 0) return unordered(s.v[0], id_of_face(element));
    if (at > 3) return unordered(s.v[0], at == 4 ? s.v[1] : at == 5 ? s.v[2] : s.v[3]);
    const Vec3<uint32_t> of_element = sides[element];  // from corner 1 to 2, 2 to 3, 3 to 1
    return unordered(s.v[0], id_of_side(at == 1 ? of_element.y : at == 2 ? of_element.z : of_element.x));
  }
  COLLIDED_HD uint64_t key_of_features(const EdgeEdge& kind, uint64_t key, uint8_t bits) const {
    const Stencil s = kind.stencil(key);
    const auto id = [&](uint32_t edge, uint32_t from, uint32_t to, int end) {
      return end == 0 ? id_of_side(edge) : end == 1 ? from : to;
    };
    return unordered(id(first_id(key), s.v[0], s.v[1], bits & kOfFirstEdge),
                     id(second_id(key), s.v[2], s.v[3], (bits & kOfSecondEdge) / 4));
  }
  COLLIDED_HD uint64_t key_of_meshes(uint32_t vertex, uint32_t other) const {
    constexpr uint32_t kOfMeshes = 3u << 30;
    static_assert(5ull * (1u << 29) < kOfMeshes);  // kMaxFeatures of vertices and of elements, three times of edges
    return unordered(kOfMeshes | meshes[vertex], kOfMeshes | meshes[other]);
  }

 private:
  COLLIDED_HD uint32_t id_of_side(uint32_t edge) const { return static_cast<uint32_t>(vertices) + edge; }
  COLLIDED_HD uint32_t id_of_face(uint32_t element) const {
    return static_cast<uint32_t>(vertices + edges().size()) + element;
  }
  COLLIDED_HD static uint64_t unordered(uint32_t a, uint32_t b) { return pack_ids(min(a, b), max(a, b)); }
};

/// Puts the closest points, by their weights, on the features that are named: parallel edges have others as near.
COLLIDED_HD inline void place_points(const VertexTriangle&, const FourPoints&, uint8_t, double*) {}
COLLIDED_HD inline void place_points(const EdgeEdge&, const FourPoints& points, uint8_t bits, double* weights) {
  const auto& p = points.p;
  const int first = bits & kOfFirstEdge, second = (bits & kOfSecondEdge) / 4;  // 0: inside, else the end
  const bool is_there = (first == 0 || weights[0] == first - 1) && (second == 0 || weights[1] == second - 1);
  if (is_there) return;
  weights[0] = first > 0 ? first - 1 : closest_on_edge(second == 1 ? p[2] : p[3], p[0], p[1] - p[0]);
  weights[1] = second > 0 ? second - 1 : closest_on_edge(first == 1 ? p[0] : p[1], p[2], p[3] - p[2]);
}

/// Finds the features of each contact.
template <class Real>
struct FindFeatures {
  OrderedContacts contacts;
  Surfaces<Real> surfaces;
  uint64_t* open;  ///< counts those that exact arithmetic has to tell; null: double precision tells

  COLLIDED_HD void operator()(uint64_t i) const {
    contacts.use_features(i, [&]<class Kind>(const Kind& kind, uint64_t key) {
      const Stencil s = kind.stencil(key);
      const FoundFeatures found = closest_features<Kind>(surfaces.points_of(s).p, s.v);
      const bool is_open = open != nullptr && !found.is_certain;
      if (is_open) atomic_add(*open, uint64_t{1});
      contacts.columns.features[i] = static_cast<uint8_t>(found.features | (is_open ? kFeaturesOpen : 0));
    });
  }
};

/// Says whether surfaces come nearer beside the features of each contact, and gives it the key that another one may
/// have, too. Slots become free.
template <class Real>
struct KeyContacts {
  OrderedContacts contacts;
  Surfaces<Real> surfaces;
  Span<uint64_t> keys;
  Span<uint32_t> slots;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint64_t count = contacts.count.size(), all = FirstPlaces::slots_for(count);
    for (uint64_t slot = i; slot < all; slot += count) slots[slot] = FirstPlaces::kNone;
    keys[i] = kNoKey;
    contacts.use_features(i, [&](const auto& kind, uint64_t key) {
      const Stencil s = kind.stencil(key);
      uint8_t& features = contacts.columns.features[i];
      const uint8_t bits = features & (kOfTriangle | kOfFirstEdge | kOfSecondEdge | kFeaturesOpen);
      features = static_cast<uint8_t>(bits | surfaces.nearer_beside(named_features(kind, s, bits)));
      keys[i] = contacts.key_of_features(kind, key, bits);
      if (!contacts.columns.weights.empty())
        place_points(kind, surfaces.points_of(s), bits, reinterpret_cast<double*>(contacts.columns.weights.data + i));
    });
    if (contacts.is_sure_crossing(i))
      keys[i] = contacts.key_of_meshes(contacts.edges()[first_id(contacts.key_of(i))].from,
                                       contacts.corners()[second_id(contacts.key_of(i))].x);
  }
};

struct ListFirstPlaces {
  Counted count;
  FirstPlaces first;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (first.keys[i] != kNoKey) first.of(count.size()).add(static_cast<uint32_t>(i));
  }
};

struct MarkCovered {
  OrderedContacts contacts;
  FirstPlaces first;
  bool flags_too;  ///< the scene has contacts of all features

  COLLIDED_HD void operator()(uint64_t i) const {
    const FirstPlaces of_step = first.of(contacts.count.size());
    contacts.use_features(i, [&](const auto& kind, uint64_t key) {
      uint8_t &features = contacts.columns.features[i], &flags = contacts.columns.flags[i];
      if (of_step.find(first.keys[i]) != i) features |= kSameAsBefore;
      const Stencil s = kind.stencil(key);
      const bool cross = of_step.find(contacts.key_of_meshes(s.v[0], s.v[3])) != FirstPlaces::kNone,
                 is_covered = (features & kSameAsBefore) != 0 ||
                              ((features & (kNearerAtFirst | kNearerAtSecond)) != 0 && !cross);
      flags = static_cast<uint8_t>((flags & ~kFlagCovered) | (flags_too && is_covered ? kFlagCovered : 0));
    });
  }
};

}  // namespace collided
