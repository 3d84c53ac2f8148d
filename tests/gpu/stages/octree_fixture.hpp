#pragma once
// The octree's arrays as vectors, for tests of its stages one by one.

#include <vector>

#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/engines/octree/refine.hpp"
#include "gpu/engines/octree/registration.hpp"

namespace collided::test {

template <class T>
Span<T> span_of(std::vector<T>& v) {
  return {v.data(), v.size()};
}

/// The cut of bricks and dense levels, as a step makes it.
inline void run_cut(CpuExec& exec, const Tree& tree, const CutCost& cost, Span<float> root_cost) {
  for (int round = tree.rounds - 1; round >= 0; --round)
    exec.for_each_group("cut_bricks", {&tree.brick_counters[round], tree.bricks.size()}, CutBricks{tree, cost, round});
  for (int step = 0; step < 3; ++step) {
    const uint64_t roots = roots_of_step(*tree.grid, step);
    exec.for_each_group("cut", {&roots, roots}, CutDense{tree, cost, root_cost, step});
  }
}

struct TestOctree {
  LevelGrid grid{{0, 0, 0}, 1, 0, 3};
  std::vector<uint32_t> counts, slot;
  std::vector<uint8_t> type;
  std::vector<Brick> bricks;
  std::vector<uint32_t> reach;
  std::vector<float> brick_cost, root_cost;
  uint64_t brick_counters[kMaxRounds] = {};
  int rounds = 0;

  explicit TestOctree(size_t most_bricks = 0)
      : counts(level_offset(kMaxLevel + 1) + most_bricks * kBrickCells, 0),
        slot(counts.size(), kNoLeaf),
        type(counts.size(), kInactive),
        bricks(most_bricks),
        reach(most_bricks),
        brick_cost(most_bricks),
        root_cost(level_offset(kMaxLevel - kBrickLevels + 1)) {}

  Tree tree() {
    return {&grid,
            level_offset(kMaxLevel + 1),
            span_of(counts),
            span_of(type),
            span_of(slot),
            span_of(bricks),
            span_of(reach),
            span_of(brick_cost),
            {},
            brick_counters,
            nullptr,
            rounds};
  }

  void cut(const CutCost& cost) {
    CpuExec exec(2, 0);
    run_cut(exec, tree(), cost, span_of(root_cost));
  }
};

}  // namespace collided::test
