#pragma once
// Section 3.1, first of the two stages: the optimal cut by dynamic programming from the base level up.
// A cell becomes a leaf if it costs no more than the best of its children together; otherwise its entry is replaced by
// their sum. On a tie the parent wins: fewer registrations for the same tests.
// Deviation: a registration may have a cost too (none, as measured), and a group works on kBrickLevels levels at once,
// so that the whole of it takes a few launches.

#include "gpu/engines/octree/count.hpp"

namespace collided {

COLLIDED_HD inline uint64_t tests_of(uint64_t triangles) { return triangles < 2 ? 0 : triangles * (triangles - 1) / 2; }

/// How the cut is chosen. kTwoStage is the paper's OTG_t; the others are the one-stage forms that it is compared with:
/// kTopDown stops where one subdivision does not pay, kBottomUp stops merging where a sibling was not merged; kGrid
/// never merges.
enum class CutRule { kTwoStage, kTopDown, kBottomUp, kGrid };

struct CutCost {
  CutRule rule = CutRule::kTwoStage;
  float per_registration = 0;  ///< in pair tests

  bool operator==(const CutCost&) const = default;

  COLLIDED_HD float of_leaf(uint32_t triangles) const {
    if (triangles < 2) return 0;
    const float n = static_cast<float>(triangles);
    return 0.5f * n * (n - 1) + per_registration * n;
  }
  /// What the parent sees of a cell; infinite: a cell that must not be merged.
  COLLIDED_HD float to_parent(float own, float children, bool leaf) const {
    if (rule == CutRule::kTopDown) return own;
    if (rule == CutRule::kBottomUp) return leaf ? own : -1.0f;
    return leaf ? own : children;
  }
};

/// Costs and types of the cells of up to kBrickLevels levels below a root; levels of `depth` above are left alone.
struct CutBelowRoot {
  /// By number below the root; the root itself is 0.
  struct Shared {
    COLLIDED_HD float& cost(uint32_t number) { return costs_[number + kShift]; }
    COLLIDED_HD float cost(uint32_t number) const { return costs_[number + kShift]; }

   private:
    static constexpr uint32_t kShift = 7;  ///< the children of a cell are two wide loads, and nothing else
    alignas(32) float costs_[kBrickCells + 1 + kShift];
  };

  /// cell_of(number) is the index of a cell; bottom(number, cell) sets the cost of one at `depth` and its type.
  template <class CellOf, class Bottom>
  COLLIDED_HD static void run(const Tree& tree, const CutCost& cost, int depth, int least_depth, const Group& group,
                              Shared& shared, const CellOf& cell_of, const Bottom& bottom) {
    const uint32_t first = level_offset(depth), end = level_offset(depth + 1);
    for (uint32_t number = first + group.rank; number < end; number += group.size)
      shared.cost(number) = bottom(number, cell_of(number));
    group.sync();
    for (int d = depth - 1; d >= least_depth; --d) {
      for (uint32_t number = level_offset(d) + group.rank; number < level_offset(d + 1); number += group.size)
        shared.cost(number) = merge(tree, cost, number, cell_of(number), shared);
      group.sync();
    }
  }

  /// What the children of a cell cost together, and whether all of them may be merged.
  struct Children {
    float cost;
    bool can_merge;
  };
  COLLIDED_HD static Children children_of(uint32_t number, const Shared& shared) {
    Children sum{0, true};
    for (uint32_t k = 1; k <= 8; ++k) {
      const float child = shared.cost(8 * number + k);
      sum.can_merge = sum.can_merge && child >= 0;
      sum.cost += child;
    }
    return sum;
  }

 private:
  COLLIDED_HD static float merge(const Tree& tree, const CutCost& cost, uint32_t number, uint32_t cell,
                                 const Shared& shared) {
    const Children children = children_of(number, shared);
    const uint32_t n = tree.counts[cell];
    const float own = cost.of_leaf(n);
    const bool leaf = children.can_merge && cost.rule != CutRule::kGrid && own <= children.cost;
    tree.type[cell] = n == 0 ? kInactive : leaf ? kLeaf : kInternal;
    return n == 0 ? 0 : cost.to_parent(own, children.cost, leaf);
  }
};

/// Cut below each brick's root; one item a brick.
struct CutBricks {
  using Shared = CutBelowRoot::Shared;
  static constexpr uint32_t kGroupSize = 128;
  Tree tree;
  CutCost cost;
  int round;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    const uint32_t brick = static_cast<uint32_t>(tree.first_brick(round) + i);
    if (brick >= tree.bricks.size()) return;
    const auto cell_of = [&](uint32_t number) { return tree.brick_cell(brick, number); };
    CutBelowRoot::run(tree, cost, kBrickLevels, 1, group, shared, cell_of, Bottom{tree, cost, round + 1 < tree.rounds});
    if (group.rank != 0) return;
    const CutBelowRoot::Children children = CutBelowRoot::children_of(0, shared);
    tree.brick_cost[brick] = children.can_merge ? children.cost : -1.0f;
  }

  /// A bottom cell: itself, or what its brick costs.
  struct Bottom {
    Tree tree;
    CutCost cost;
    bool may_have_brick;

    COLLIDED_HD float operator()(uint32_t, uint32_t cell) const {
      const uint32_t n = tree.counts[cell];
      const float own = cost.of_leaf(n);
      if (may_have_brick && tree.type[cell] == kRefined) {
        const float below = tree.brick_cost[tree.slot[cell]];
        const bool leaf = below >= 0 && own <= below;
        if (leaf) tree.type[cell] = kLeaf;
        return cost.to_parent(own, below, leaf);
      }
      tree.type[cell] = n == 0 ? kInactive : kLeaf;
      return own;
    }
  };
};

/// Cut of the dense levels, kBrickLevels at once: step s goes up from level base - s * kBrickLevels; one item a root.
struct CutDense {
  using Shared = CutBelowRoot::Shared;
  static constexpr uint32_t kGroupSize = 128;
  Tree tree;
  CutCost cost;
  Span<float> root_cost;  ///< by number of the cell, down to kBrickLevels above the last dense level
  int step;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    const LevelGrid grid = *tree.grid;
    const int bottom = grid.base - step * kBrickLevels;
    const int root = bottom < kBrickLevels ? 0 : bottom - kBrickLevels;
    const auto cell_of = [&](uint32_t number) {
      const int depth = number == 0 ? 0 : number < 9 ? 1 : number < 73 ? 2 : 3;
      return level_offset(root + depth) + (static_cast<uint32_t>(i) << (3 * depth)) + number - level_offset(depth);
    };
    const int depth = bottom - root, least = grid.top > root ? grid.top - root : 0;
    const bool is_below_others = least == 0 && root > grid.top;
    if (step == 0 && is_empty(group, level_offset(depth), level_offset(depth + 1), cell_of)) {
      if (group.rank == 0 && is_below_others) root_cost[cell_of(0)] = 0;
      return;  // nobody asks for the type of an empty cell
    }
    if (step == 0)
      CutBelowRoot::run(tree, cost, depth, least, group, shared, cell_of,
                        CutBricks::Bottom{tree, cost, tree.rounds > 0});
    else
      CutBelowRoot::run(tree, cost, depth, least, group, shared, cell_of,
                        [&](uint32_t, uint32_t cell) { return root_cost[cell]; });
    if (group.rank == 0 && is_below_others) root_cost[cell_of(0)] = shared.cost(0);
  }

 private:
  template <class CellOf>
  COLLIDED_HD bool is_empty(const Group& group, uint32_t first, uint32_t end, const CellOf& cell_of) const {
    bool has_triangles = false;
    for (uint32_t number = first + group.rank; number < end; number += group.size)
      has_triangles = has_triangles || tree.counts[cell_of(number)] != 0;
    return !group.any(has_triangles);
  }
};

/// Roots of each step, for the launch of CutDense.
COLLIDED_HD inline uint64_t roots_of_step(const LevelGrid& grid, int step) {
  const int bottom = grid.base - step * kBrickLevels;
  if (step > 0 && bottom <= grid.top) return 0;
  return bottom < kBrickLevels ? 1 : uint64_t{1} << (3 * (bottom - kBrickLevels));
}

}  // namespace collided
