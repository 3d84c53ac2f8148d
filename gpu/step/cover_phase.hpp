#pragma once
// The features that contacts have their closest points on, and which contacts others cover, when all are in order.

#include "gpu/narrow/covering.hpp"
#include "gpu/state/context.hpp"

namespace collided {

template <Executor Exec, class Real>
class CoverPhase {
 public:
  explicit CoverPhase(const StepContext<Exec, Real>& context) : context_(context) {}

  void reserve() {
    const uint64_t most = context_.scene.contacts.keys.capacity();
    context_.scene.pair_keys.allocate(most);
    context_.scene.pair_slots.allocate(FirstPlaces::slots_for(most));
  }
  /// Puts all in line.
  void run(const LevelNeeds& needs) {
    const OrderedContacts contacts = this->contacts(needs);
    uint64_t* open = needs.is_exact() ? &context_.state()->open_features : nullptr;
    context_.exec.for_each("find_features", contacts.count,
                           FindFeatures<Real>{contacts, context_.scene.end.data(), open});
    cover(needs);
  }
  /// The same of contacts that have their features.
  void cover(const LevelNeeds& needs) {
    SceneBuffers<Exec, Real>& scene = context_.scene;
    const OrderedContacts contacts = this->contacts(needs);
    const FirstPlaces first{scene.pair_keys.all(), scene.pair_slots.all()};
    context_.exec.for_each(
        "key_contacts", contacts.count,
        KeyContacts<Real>{contacts, scene.surfaces(), scene.pair_keys.all(), scene.pair_slots.all()});
    context_.exec.for_each("list_first_places", contacts.count, ListFirstPlaces{contacts.count, first});
    context_.exec.for_each("mark_covered", contacts.count,
                           MarkCovered{contacts, first, needs.kinds.vertex_triangle && needs.kinds.edge_edge});
  }

 private:
  OrderedContacts contacts(const LevelNeeds& needs) const {
    const SceneBuffers<Exec, Real>& scene = context_.scene;
    const ResidentTopology<Exec>& topology = scene.topology;
    const uint64_t most = scene.contacts.keys.capacity();
    return {scene.columns.columns(needs.columns()),
            {&context_.state()->contacts, most, most},
            &context_.state()->kinds,
            FeatureKinds::of(topology),
            topology.edge_ends(),
            topology.corners(),
            topology.sides(),
            topology.meshes(),
            context_.counts.vertices};
  }

  const StepContext<Exec, Real>& context_;
};

}  // namespace collided
