#pragma once
// What is decided for a step before it starts. Steps of equal plans put the same work in line.

#include <cstdint>
#include <deque>

#include "gpu/contacts/order.hpp"
#include "gpu/octree/bottom_up.hpp"
#include "gpu/octree/leaf_pairs.hpp"
#include "gpu/octree/tree.hpp"
#include "gpu/step/level_needs.hpp"

namespace collided {

/// Of the octree grid.
struct OctreePlan {
  Engine engine = Engine::kOctree;
  CutCost cost;
  int rounds = 0;         ///< of refinement below the dense levels
  int levels = 0;         ///< dense levels, at most
  int base = 0;           ///< lowest dense level, at most
  bool has_large = true;  ///< there may be triangles that cover many cells
  /// For each triangle with a box; beyond this the step runs again.
  uint64_t max_crowded_tests = kAnyNumberOfTests;

  /// Whether the engine's stages are the octree's.
  bool has_octree() const { return engine != Engine::kLbvh && engine != Engine::kAllPairs; }

  bool operator==(const OctreePlan&) const = default;
};

/// Of the lists of neighbours that a step makes or goes by.
struct ListPlan {
  ListUse use = ListUse::kNone;
  double margin = 0;  ///< of lists that are made; unit of the positions
  double frames = 0;  ///< that these are meant for

  bool operator==(const ListPlan&) const = default;
};

struct StepPlan {
  LevelNeeds needs = {};
  OctreePlan octree = {};
  bool boxes_static = true;  ///< meshes that never move are boxed too
  OrderPlan order = {};
  ListPlan lists = {};
  bool is_idle = false;  ///< nothing may touch: the step searches for nothing

  /// Whether there are octree and hierarchy at all.
  bool searches() const { return lists.use != ListUse::kReused; }

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
