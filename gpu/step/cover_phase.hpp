#pragma once
// The features that contacts have their closest points on, and which contacts others cover, when all are in order.

#include "gpu/narrow/covering.hpp"
#include "gpu/state/buffers.hpp"
#include "gpu/state/level_needs.hpp"

namespace collided {

template <Executor Exec, class Real>
class CoverPhase {
 public:
  CoverPhase(Exec& exec, SceneBuffers<Exec, Real>& scene) : exec_(exec), scene_(scene) {}

  void reserve() {
    const uint64_t most = scene_.contacts.keys.capacity();
    scene_.pair_keys.allocate(most);
    scene_.pair_slots.allocate(FirstPlaces::slots_for(most));
  }
  /// Puts all in line. `are_known`: contacts have their features.
  void run(const LevelNeeds& needs, bool are_known = false) {
    const OrderedContacts contacts = this->contacts(needs);
    const FirstPlaces first{scene_.pair_keys.all(), scene_.pair_slots.all()};
    if (!are_known)
      exec_.for_each("find_features", contacts.count,
                     FindFeatures<Real>{contacts, scene_.surfaces(),
                                        needs.is_exact() ? &scene_.state.data()->open_features : nullptr});
    exec_.for_each("key_contacts", contacts.count,
                   KeyContacts<Real>{contacts, scene_.surfaces(), scene_.pair_keys.all(), scene_.pair_slots.all()});
    exec_.for_each("list_first_places", contacts.count, ListFirstPlaces{contacts.count, first});
    exec_.for_each("mark_covered", contacts.count,
                   MarkCovered{contacts, first, needs.kinds.vertex_triangle && needs.kinds.edge_edge});
  }

 private:
  OrderedContacts contacts(const LevelNeeds& needs) const {
    const ResidentTopology<Exec>& topology = scene_.topology;
    StepState* state = scene_.state.data();
    const uint64_t most = scene_.contacts.keys.capacity();
    return {scene_.columns.columns(needs.columns()),
            {&state->contacts, most, most},
            &state->kinds,
            FeatureKinds::of(topology),
            topology.sides(),
            topology.meshes(),
            uint64_t{topology.shape.worlds} * topology.shape.vertices};
  }

  Exec& exec_;
  SceneBuffers<Exec, Real>& scene_;
};

}  // namespace collided
