#pragma once
// Contacts that stay on the backend: their columns go from where the step left them to the frame's ContactRoom.

#include "gpu/state/buffers.hpp"
#include "gpu/state/level_needs.hpp"

namespace collided {

template <Executor Exec, class Real>
class Placing {
 public:
  Placing(Exec& exec, SceneBuffers<Exec, Real>& scene) : exec_(exec), scene_(scene) {}

  /// What the next steps do. The memory itself is no part of a recorded step, so that frames may take turns in it.
  void begin(const ContactRoom& room) {
    if (room.memory.empty()) return;
    scene_.room.allocate(1);
    scene_.layout.allocate(1);
    const Span<std::byte> next{room.memory.data(), room.memory.size()};
    if (next.data == room_.data && next.count == room_.count) return;
    room_ = next;
    exec_.upload(scene_.room.data(), &room_, sizeof(room_));
  }

  /// The buffers are new.
  void begin_anew() { room_ = {}; }

  /// Puts in line that the contacts of the step are placed, and that the earliest time of all is found.
  void place(const LevelNeeds& needs) {
    StepState* state = scene_.state.data();
    const Counted count = listed(needs);
    const ContactColumns columns = scene_.columns.columns(needs.columns());
    const LayOutContacts lay_out{needs.widths, &state->kinds, count, scene_.room.data(), scene_.layout.data()};
    if (needs.has_times() && !needs.is_exact())
      exec_.reduce_into("earliest_toi", count.most, TimeOfContact{columns, count, needs.settings.ignore_separating},
                        1.0, Earlier{}, &state->earliest_toi, lay_out);
    else
      exec_.for_each("lay_out_contacts", 1, lay_out);
    exec_.for_each("place_contacts", count,
                   PlaceContact{needs.widths, scene_.layout.data(), scene_.room.data(), columns,
                                FeatureKinds::of(scene_.topology)});
  }

  /// Where they lie, by the numbers of the step.
  ContactLayout layout(const LevelNeeds& needs, const KindBegins& begins, uint64_t count) const {
    return lay_out(needs.widths, begins, count, room_.size());
  }

  /// How many of the contacts that a step found are listed: of those that are all the earliest, the first.
  static uint64_t most_listed(const LevelNeeds& needs, uint64_t found) {
    return needs.is_earliest_only() ? min(found, uint64_t{1}) : found;
  }

 private:
  Counted listed(const LevelNeeds& needs) const {
    StepState* state = scene_.state.data();
    return needs.is_earliest_only() ? Counted{&state->earliest, most_listed(needs, scene_.earliest.keys.capacity())}
                                    : Counted{&state->contacts, scene_.contacts.keys.capacity()};
  }

  Exec& exec_;
  SceneBuffers<Exec, Real>& scene_;
  Span<std::byte> room_;  ///< that the backend was told last
};

}  // namespace collided
