#pragma once
// The whole broad phase on boxes, stage by stage as the engine runs it, in lists of any length with guards behind them.

#include <algorithm>
#include <array>
#include <utility>

#include "gpu/engines/octree/leaf_pairs.hpp"
#include "gpu/engines/octree/levels.hpp"
#include "gpu/search/cpu/pair_search.hpp"
#include "tests/gpu/stages/octree_fixture.hpp"

namespace collided::test {

/// A list with memory behind its end that nobody may write to. What it holds at first is rubbish, as on a device.
template <class T>
class Guarded {
 public:
  explicit Guarded(uint64_t size) : bytes_((size + kGuard) * sizeof(T), kRubbish), size_(size) {}

  Span<T> span() { return {reinterpret_cast<T*>(bytes_.data()), size_}; }
  T& operator[](uint64_t i) { return span()[i]; }
  uint64_t size() const { return size_; }
  bool is_intact() const {
    const auto guard = bytes_.begin() + static_cast<std::ptrdiff_t>(size_ * sizeof(T));
    return std::all_of(guard, bytes_.end(), [](uint8_t byte) { return byte == kRubbish; });
  }

 private:
  static constexpr uint64_t kGuard = 64;
  static constexpr uint8_t kRubbish = kRefined;  // a cell type that is wrong in most places
  std::vector<uint8_t> bytes_;
  uint64_t size_;
};

/// Lengths of the lists that a step may find too short.
struct ListLengths {
  uint64_t large, bricks, brick_items, leaves, registrations, items;

  std::array<uint64_t, 6> all() const { return {large, bricks, brick_items, leaves, registrations, items}; }
};

using BoxPairs = std::vector<std::pair<uint32_t, uint32_t>>;

class OctreeBuild {
 public:
  OctreeBuild(const std::vector<Box<float>>& boxes, int top, int base, int rounds, const ListLengths& lengths)
      : grid(grid_over(bounds_of(boxes), top, base)),
        counts(level_offset(base + 1) + lengths.bricks * kBrickCells),
        slot(counts.size()),
        type(counts.size()),
        bricks(lengths.bricks),
        reach(lengths.bricks),
        brick_cost(lengths.bricks),
        root_cost(level_offset(kMaxLevel - kBrickLevels + 1)),
        large(lengths.large),
        leaves(lengths.leaves),
        cursor(lengths.leaves),
        registered(lengths.registrations),
        items(lengths.items),
        brick_items(lengths.brick_items),
        rounds_(rounds),
        boxes_(boxes.data(), boxes.size()) {
    count();
    refine();
    run_cut(exec_, tree(), {CutRule::kTwoStage, 4}, root_cost.span());
    place_and_register();
  }

  ListLengths need() const {
    uint64_t all_bricks = 0, all_in_bricks = 0;
    for (const uint64_t n : brick_counters) all_bricks += n;
    for (const uint64_t n : brick_item_counters) all_in_bricks += n;
    return {large_count,
            all_bricks,
            all_in_bricks,
            totals[LeafSum::kLeaves],
            totals[LeafSum::kRegistrations],
            totals[LeafSum::kItems]};
  }
  bool is_intact() const {
    return counts.is_intact() && slot.is_intact() && type.is_intact() && bricks.is_intact() && reach.is_intact() &&
           brick_cost.is_intact() && root_cost.is_intact() && large.is_intact() && leaves.is_intact() &&
           cursor.is_intact() && registered.is_intact() && items.is_intact() && brick_items.is_intact();
  }
  /// Whether all that a search would read is there, if it took place.
  bool items_are_sound() {
    if (pairs_source().must_rerun()) return true;
    for (uint64_t i = 0; i < totals[LeafSum::kItems]; ++i)
      if (items[i].leaf >= totals[LeafSum::kLeaves] || !holds_boxes(leaves[items[i].leaf])) return false;
    return true;
  }
  bool must_rerun() { return pairs_source().must_rerun(); }
  /// Of all items, with repeats if there are any; sorted.
  BoxPairs pairs() {
    const LeafPairs source = pairs_source();
    BoxPairs found;
    LeafTiles tiles;
    for (uint64_t i = 0; i < std::min(totals[LeafSum::kItems], items.size()); ++i)
      visit_item(source, i, tiles, [&](uint32_t a, uint32_t b) { found.emplace_back(std::min(a, b), std::max(a, b)); });
    std::sort(found.begin(), found.end());
    return found;
  }

  LevelGrid grid;
  Guarded<uint32_t> counts, slot;
  Guarded<uint8_t> type;
  Guarded<Brick> bricks;
  Guarded<uint32_t> reach;
  Guarded<float> brick_cost, root_cost;
  Guarded<uint32_t> large;
  Guarded<Leaf> leaves;
  Guarded<uint32_t> cursor, registered;
  Guarded<PairItem> items;
  Guarded<BrickItem> brick_items;
  uint64_t brick_counters[kMaxRounds] = {}, brick_item_counters[kMaxRounds] = {};
  uint64_t large_count = 0;
  LeafTotals totals{};

 private:
  static Box<float> bounds_of(const std::vector<Box<float>>& boxes) {
    Box<float> bounds = boxes.front();
    for (const Box<float>& box : boxes) bounds = join(bounds, box);
    return bounds;
  }

  LeafPairs pairs_source() {
    return {&grid, {}, boxes_, leaves.span(), registered.span(), items.span(), &totals, registered.size()};
  }
  bool holds_boxes(const Leaf& leaf) {
    if (leaf.offset + leaf.count > registered.size()) return false;
    for (uint64_t i = leaf.offset; i < leaf.offset + leaf.count; ++i)
      if (registered[i] >= boxes_.size()) return false;
    return true;
  }

  Tree tree() {
    return {&grid,
            level_offset(grid.base + 1),
            counts.span(),
            type.span(),
            slot.span(),
            bricks.span(),
            reach.span(),
            brick_cost.span(),
            brick_items.span(),
            brick_counters,
            brick_item_counters,
            rounds_};
  }
  CellsOfLarge cells_of_large() { return {&grid, boxes_, large.span()}; }
  Counted large_items() const { return {&large_count, large.size()}; }
  Counted bricks_of(int round) const { return {&brick_counters[round], bricks.size()}; }

  Counted items_of_bricks(int round) const { return {&brick_item_counters[round], brick_items.size()}; }

  Counted all_boxes() const { return {nullptr, boxes_.size()}; }
  void count() {
    exec_.fill_zero(counts.span().data, level_offset(grid.base + 1) * sizeof(uint32_t));
    exec_.for_each_part("count", all_boxes(),
                        CountOverlappedCells{{&grid, boxes_}, counts.span(), {large.span(), &large_count}});
    exec_.for_each_of_many_parts("count_large", large_items(), CountCellsOfLarge{cells_of_large(), counts.span()});
  }
  void refine() {
    for (int round = 0; round < rounds_; ++round) {
      const ListInBricks list{tree(), round};
      if (round == 0) {
        exec_.for_each("open_first", uint64_t{1} << (3 * grid.base), OpenFirstBricks{tree()});
        exec_.for_each_part("list", all_boxes(), ListInFirstBricks{list, {&grid, boxes_}});
        exec_.for_each_of_many_parts("list_large", large_items(), ListLargeInFirstBricks{list, cells_of_large()});
      } else {
        exec_.for_each_group("open", bricks_of(round - 1), OpenBricks{tree(), round});
        exec_.for_each_part("list", items_of_bricks(round - 1), ListInNextBricks{list, {tree(), boxes_, round - 1}});
      }
      exec_.for_each_group("clear", bricks_of(round), ClearBricks{tree(), round});
      exec_.for_each_part("count", items_of_bricks(round), CountInBricks{{tree(), boxes_, round}});
    }
  }
  void place_and_register() {
    const PlaceLeaves place{tree(), leaves.span(), cursor.span(), registered.size(), items.span(), &totals};
    exec_.for_each_group("place", {&cell_groups_, cell_groups_}, PlaceDenseLeaves{place});
    for (int round = 0; round < rounds_; ++round)
      exec_.for_each_group("place_bricks", bricks_of(round), PlaceBrickLeaves{place, round});
    const Registration registration{tree(), cursor.span(), registered.span()};
    exec_.for_each_part("register", all_boxes(), RegisterTriangles<CellsOfTriangles>{registration, {&grid, boxes_}});
    exec_.for_each_of_many_parts("register_large", large_items(),
                                 RegisterTriangles<CellsOfLarge>{registration, cells_of_large()});
    for (int round = 0; round < rounds_; ++round)
      exec_.for_each_part("register_in_bricks", items_of_bricks(round),
                          RegisterTriangles<CellsInBricks>{registration, {tree(), boxes_, round}});
  }

  CpuExec exec_{2, 0};
  int rounds_;
  Span<const Box<float>> boxes_;
  uint64_t cell_groups_ = groups_of_cells(grid);
};

}  // namespace collided::test
