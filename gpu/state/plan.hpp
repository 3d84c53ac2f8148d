#pragma once
// What is decided for a step before it starts. Steps of equal plans put the same work in line.

#include <cstdint>
#include <deque>

#include "gpu/contacts/order.hpp"
#include "gpu/engines/octree/octree_plan.hpp"
#include "gpu/state/level_needs.hpp"

namespace collided {

/// Of the lists of neighbours that a step makes or goes by.
struct ListPlan {
  ListUse use = ListUse::kNone;
  double margin = 0;  ///< of lists that are made; unit of the positions
  double frames = 0;  ///< that these are meant for

  bool operator==(const ListPlan&) const = default;
};

struct StepPlan {
  LevelNeeds needs = {};
  Engine engine = Engine::kOctree;  ///< that searches, if the step does
  OctreePlan octree = {};           ///< of engines on the octree's stages
  bool boxes_static = true;         ///< meshes that never move are boxed too
  OrderPlan order = {};
  ListPlan lists = {};
  bool is_idle = false;  ///< nothing may touch: the step searches for nothing

  /// True if an engine has work: the step neither goes by lists alone nor is idle.
  bool has_engine() const { return searches() && !is_idle; }
  bool searches() const { return lists.use != ListUse::kReused; }
  bool makes_lists() const { return lists.use == ListUse::kMade; }

  bool operator==(const StepPlan&) const = default;
};

/// Numbers for the plans of a scene: two steps have the same number only if their plans are equal.
class PlanNumbers {
 public:
  uint64_t number_of(const StepPlan& plan) {
    for (const Numbered& known : known_)
      if (known.plan == plan) return known.number;
    if (known_.size() == kMaxKnown) known_.pop_front();
    known_.push_back({plan, next_});
    return next_++;
  }
  /// Plans get other numbers from here on: the same plan is other work.
  void begin_anew() { known_.clear(); }

 private:
  static constexpr size_t kMaxKnown = 32;
  struct Numbered {
    StepPlan plan;
    uint64_t number;
  };
  std::deque<Numbered> known_;
  uint64_t next_ = 0;
};

}  // namespace collided
