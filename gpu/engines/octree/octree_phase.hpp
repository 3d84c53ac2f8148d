#pragma once
// Steps 2 to 7 of Fig. 7: from boxes to pairs of triangles whose boxes overlap, for all engines on the octree's stages.
// Everything is enqueued for the backend; no length is read back.

#include <string>
#include <utility>

#include "gpu/engines/broad_phase.hpp"
#include "gpu/engines/octree/cell_grid.hpp"
#include "gpu/engines/octree/octree_buffers.hpp"
#include "gpu/engines/octree/octree_planner.hpp"
#include "gpu/engines/octree/refine.hpp"
#include "gpu/engines/octree/registration.hpp"
#include "gpu/engines/octree/subdivision.hpp"

namespace collided {

/// Side of a uniform grid's cell, and of a small cell of a two-level grid, in mean triangles. Of 1, 1.5 and 2, 1 makes
/// the fewest tests in all scenes, and the least work with them and the registrations in most.
constexpr double kCellPerMean = 1;

template <Executor Exec, class Real>
class OctreePhase {
 public:
  static constexpr Engine kEngine = Engine::kOctree;
  static constexpr bool serves(Engine engine) { return is_on_octree(engine); }

  explicit OctreePhase(const StepContext<Exec, Real>& context)
      : context_(context), exec_(context.exec), tree_(context.exec), planner_(context.triangles()) {}

  /// The scene has another number of triangles from the next step on.
  void resize() { planner_.resize(triangle_count()); }
  void plan(StepPlan& step) const {
    step.octree = planner_.plan(step.engine, !Exec::kLaunchesCost, step.makes_lists());
  }
  void begin(const StepPlan& step) { needs_ = step.needs, plan_ = step.octree, is_widened_ = step.makes_lists(); }

  void reserve() {
    reserve_lists();
    const ActiveLevels& levels = planner_.levels(is_widened_);
    if (std::exchange(sent_levels_, levels) == levels) return;
    exec_.upload(tree_.wanted.data(), &sent_levels_, sizeof(sent_levels_));
  }
  void clear() { exec_.fill_zero(tree_.counts.data(), level_offset(plan_.base + 1) * sizeof(uint32_t)); }

  // Section 3.2: number of levels.
  void measure() { has_cells_of_triangles(plan_.engine) ? choose_cells() : choose_levels(); }

  // 2.-5. From counts to cell-triangle pairs.
  void build() {
    exec_.stage("count", [&] { count_overlapped_cells(); });
    if (plan_.rounds > 0) exec_.stage("refine", [&] { refine(); });
    exec_.stage("bottom_up", [&] { cut(); });
    exec_.stage("top_down", [&] { place_leaves(); });
    exec_.stage("registration", [&] { register_triangles(); });
  }

  // 6.-7. Broad-phase tests, spread evenly; what they find goes to the sink.
  template <class Sink>
  void search(const char* name, const Sink& sink, uint64_t* next_item, bool) {
    LeafPairs source = leaf_pairs(tree_.registered.all());
    if (has_control_bits()) source.registered = tree_.ordered.all(), source.by_start = tree_.by_start.all();
    const Counted items{&state()->leaves[LeafSum::kItems], tree_.items.capacity()};
    context_.searcher.search(name, items, next_item, source, sink);
  }

  bool grow(const StepState& found) {
    const bool grew = grow_lists(found), missed_large = planner_.missed_large(found, plan_);
    return grew || missed_large;
  }
  bool must_refine(const StepState& found) { return planner_.needs_refinement(found, plan_); }
  /// Keeps the levels that suit the step for the next ones.
  void finish(const StepState& found, FrameCounts&) {
    if (!has_cells_of_triangles(plan_.engine)) planner_.learn_levels(found, is_widened_);
  }

  bool holds_memory() const { return tree_.counts.capacity() > 0; }
  void release() {
    tree_ = OctreeBuffers<Exec>(exec_);
    sent_levels_ = kNoLevels;
  }

  const OctreeBuffers<Exec>& buffers() const { return tree_; }

  // What measure() and build() consist of, one by one.

  void choose_levels() {
    StepState* state = this->state();
    measure_bounds(exec_, context_.size());
    context_.scene.leave_out_idle(exec_, triangle_count());
    exec_.reduce_into("covered_per_level", triangle_count(), CoveredPerLevel{&state->bounds, boxes()}, LevelTotals{},
                      AddTotals{}, &state->totals,
                      PrepareStep{{&state->bounds, &state->totals, tree_.wanted.data(), &state->grid},
                                  context_.prepare_narrow(needs_)});
  }

  /// For grids whose cells are as large as the triangles.
  void choose_cells() {
    StepState* state = this->state();
    const MeanExtent mean{&state->bounds, &state->extents, triangle_count()};
    LevelGrid* grid = &state->grid.grid;
    measure_bounds(exec_, context_.size());
    const auto span = [&]<class Mean>(const Mean& length) {
      return SpanCells<Mean>{&state->bounds, length, kCellPerMean, deepest_base(triangle_count()), grid};
    };
    measure_extents(exec_, context_.size(), span(mean));
    context_.scene.leave_out_idle(exec_, triangle_count());
    if (plan_.engine == Engine::kVss)  // then by those that are not large
      exec_.reduce_into("ordinary_extents", triangle_count(), OrdinaryExtentOf{mean, boxes()}, OrdinaryExtents{},
                        AddOrdinaryExtents{}, &state->ordinary, span(OrdinaryMean{&state->bounds, &state->ordinary}));
    exec_.reduce_into(
        "covered_per_level", triangle_count(), CoveredPerLevelOf{grid, boxes()}, LevelTotals{}, AddTotals{},
        &state->totals,
        ChooseCells{&state->totals, plan_.engine == Engine::kTwoLevelGrid ? kLevelsOfCrowdedCell : 0, &state->grid});
    exec_.for_each("prepare_narrow", 1, context_.prepare_narrow(needs_));
  }

  // 2. Counter tree_.
  void count_overlapped_cells() {
    const Span<uint32_t> counts = tree_.counts.all();
    exec_.for_each_part("count_overlapped_cells", all_triangles(),
                        CountOverlappedCells{{grid(), boxes()}, counts, {tree_.large.all(), &state()->large}});
    exec_.for_each_of_many_parts("count_cells_of_large", large(), CountCellsOfLarge{cells_of_large(), counts});
  }

  void refine() {
    const Tree all = tree();
    for (int round = 0; round < plan_.rounds; ++round) {
      const ListInBricks list{all, round};
      if (round == 0) {
        exec_.for_each("open_first_bricks", base_cells(), OpenFirstBricks{all});
        exec_.for_each_part("list_in_first_bricks", all_triangles(), ListInFirstBricks{list, {grid(), boxes()}});
        exec_.for_each_of_many_parts("list_large_in_first_bricks", large(),
                                     ListLargeInFirstBricks{list, cells_of_large()});
      } else {
        exec_.for_each_group("open_bricks", bricks(round - 1), OpenBricks{all, round});
        exec_.for_each_part("list_in_next_bricks", brick_items(round - 1),
                            ListInNextBricks{list, {all, boxes(), round - 1}});
      }
      exec_.for_each_group("clear_bricks", bricks(round), ClearBricks{all, round});
      exec_.for_each_part("count_in_bricks", brick_items(round), CountInBricks{{all, boxes(), round}});
    }
  }

  // 3. Bottom-up stage.
  void cut() {
    const Tree all = tree();
    if (plan_.engine == Engine::kTwoLevelGrid) return exec_.for_each("cut_crowded", top_cells(), CutCrowded{all});
    for (int round = plan_.rounds - 1; round >= 0; --round)
      exec_.for_each_group("cut_bricks", bricks(round), CutBricks{all, plan_.cost, round});
    for (int step = 0; step * kBrickLevels < max(1, plan_.levels - 1); ++step)
      exec_.for_each_group("cut_dense", roots(step), CutDense{all, plan_.cost, tree_.root_cost.all(), step});
  }

  // 4. Top-down stage: the leaves of the cut and their places.
  void place_leaves() {
    const PlaceLeaves place{tree(),
                            tree_.leaves.all(),
                            tree_.cursor.all(),
                            tree_.registered.capacity(),
                            tree_.items.all(),
                            &state()->leaves,
                            context_.scene.share.data()};
    exec_.for_each_group("place_dense_leaves", cell_groups(), PlaceDenseLeaves{place});
    for (int round = 0; round < plan_.rounds; ++round)
      exec_.for_each_group("place_brick_leaves", bricks(round), PlaceBrickLeaves{place, round});
  }

  // 5. Cell-triangle pairs.
  void register_triangles() {
    const Registration registration{tree(), tree_.cursor.all(), tree_.registered.all()};
    exec_.for_each_part("register_triangles", all_triangles(),
                        RegisterTriangles<CellsOfTriangles>{registration, {grid(), boxes()}});
    exec_.for_each_of_many_parts("register_large", large(),
                                 RegisterTriangles<CellsOfLarge>{registration, cells_of_large()});
    for (int round = 0; round < plan_.rounds; ++round)
      exec_.for_each_part("register_in_bricks", brick_items(round),
                          RegisterTriangles<CellsInBricks>{registration, {registration.tree, boxes(), round}});
    if (!has_control_bits()) return;
    const Counted leaves{&state()->leaves[LeafSum::kLeaves], tree_.leaves.capacity()};
    exec_.for_each_group("order_by_control_bits", leaves,
                         OrderByControlBits{leaf_pairs(tree_.registered.all()), tree_.ordered.all(),
                                            tree_.by_start.all(), &state()->leaves});
  }

 private:
  StepState* state() const { return context_.state(); }
  uint64_t triangle_count() const { return context_.triangles(); }
  uint32_t dense_cells() const { return level_offset(deepest_base(triangle_count()) + 1); }
  Span<const Box<float>> boxes() const { return context_.boxes(); }
  const LevelGrid* grid() const { return &state()->grid.grid; }
  bool has_control_bits() const { return plan_.engine == Engine::kVss; }
  LeafPairs leaf_pairs(Span<const uint32_t> registered) const {
    return {grid(),           context_.scene.pair_filter(),
            boxes(),          tree_.leaves.all(),
            registered,       tree_.items.all(),
            &state()->leaves, tree_.registered.capacity(),
            &state()->totals, plan_.max_crowded_tests};
  }
  CellsOfLarge cells_of_large() const { return {grid(), boxes(), tree_.large.all()}; }

  // Lengths, and bounds that the host knows: blocks of which most have nothing to do take their time too.
  Counted large() const { return {&state()->large, plan_.has_large ? tree_.large.capacity() : 0}; }
  Counted base_cells() const { return {&state()->grid.base_cells, uint64_t{1} << (3 * plan_.base)}; }
  Counted top_cells() const { return {&state()->grid.top_cells, dense_cells()}; }
  Counted cell_groups() const { return {&state()->grid.cell_groups, groups_of_cells({{}, 0, 0, plan_.base})}; }
  Counted roots(int step) const { return {&state()->grid.roots[step], roots_of_step({{}, 0, 0, plan_.base}, step)}; }
  Counted bricks(int round) const { return {&state()->bricks[round], tree_.bricks.capacity()}; }

  Counted brick_items(int round) const { return {&state()->brick_items[round], tree_.brick_items.capacity()}; }
  Counted all_triangles() const { return {nullptr, triangle_count()}; }

  Tree tree() const {
    return {grid(),
            dense_cells(),
            tree_.counts.all(),
            tree_.type.all(),
            tree_.slot.all(),
            tree_.bricks.all(),
            tree_.reach.all(),
            tree_.brick_cost.all(),
            tree_.brick_items.all(),
            state()->bricks,
            state()->brick_items,
            plan_.rounds};
  }

  /// Lists start at what most scenes need. Those that go together may be of different lengths since a step that ran out
  /// of memory.
  void reserve_lists() {
    const uint64_t n = triangle_count();
    const ListLengths& expected = context_.scene.expected;
    OctreeBuffers<Exec>& tree = tree_;
    tree.wanted.allocate(1);
    if (plan_.rounds > 0) {
      begin_list(tree.bricks, min(n / 16 + 1, uint64_t{256}), expected[ListLengths::kBricks]);
      begin_list(tree.brick_items, n + first_length(n), expected[ListLengths::kBrickItems]);
      tree.reach.allocate(tree.bricks.capacity());
      tree.brick_cost.allocate(tree.bricks.capacity());
    }
    reserve_cells();
    tree.root_cost.allocate(level_offset(deepest_base(n) - kBrickLevels + 1));
    begin_list(tree.large, min(n, uint64_t{256}), expected[ListLengths::kLarge]);
    begin_list(tree.leaves, n / 2 + first_length(n), expected[ListLengths::kLeaves]);
    tree.cursor.allocate(tree.leaves.capacity());
    begin_list(tree.registered, 6 * n + first_length(n), expected[ListLengths::kRegistrations]);
    begin_list(tree.items, n + first_length(n), expected[ListLengths::kPairItems]);
    if (!has_control_bits()) return;
    tree.ordered.allocate(tree.registered.capacity());
    tree.by_start.allocate(tree.leaves.capacity());
  }

  /// Makes room for what a step asked for. Returns true if there was too little.
  bool grow_lists(const StepState& found) {
    OctreeBuffers<Exec>& tree = tree_;
    const ListLengths need = lengths_of(found);
    check_length("registrations", need[ListLengths::kRegistrations]);
    check_length("items of pair tests", need[ListLengths::kPairItems]);
    bool short_of_room = false;
    const auto check = [&](const auto& buffer, uint64_t count, const auto& enlarge) {
      if (count <= buffer.capacity()) return;
      short_of_room = true;
      enlarge(count);
    };
    check(tree.large, need[ListLengths::kLarge], [&](uint64_t n) { tree.large.ensure(n); });
    check(tree.bricks, need[ListLengths::kBricks], [&](uint64_t n) { reserve_bricks(n + n / 4); });
    check(tree.brick_items, need[ListLengths::kBrickItems], [&](uint64_t n) { tree.brick_items.ensure(n); });
    check(tree.leaves, need[ListLengths::kLeaves], [&](uint64_t n) { reserve_leaves(n + n / 4); });
    check(tree.registered, need[ListLengths::kRegistrations], [&](uint64_t n) { tree.registered.ensure(n); });
    check(tree.items, need[ListLengths::kPairItems], [&](uint64_t n) { tree.items.ensure(n); });
    return short_of_room;
  }

  static void check_length(const std::string& list, uint64_t need) {
    if (need >= ~0u)
      throw ResourceExhausted("the octree needs " + std::to_string(need) + " " + list + ", the limit is " +
                              std::to_string(~0u - 1));
  }
  void reserve_leaves(uint64_t count) {
    tree_.leaves.allocate(count);
    tree_.cursor.allocate(count);
  }
  void reserve_bricks(uint64_t count) {
    OctreeBuffers<Exec>& tree = tree_;
    tree.bricks.allocate(count);
    tree.reach.allocate(count);
    tree.brick_cost.allocate(count);
    reserve_cells();
  }
  void reserve_cells() {
    OctreeBuffers<Exec>& tree = tree_;
    const uint64_t cells = dense_cells() + tree.bricks.capacity() * kBrickCells;
    tree.counts.allocate(cells);
    tree.type.allocate(cells);
    tree.slot.allocate(cells);
  }

  static constexpr ActiveLevels kNoLevels = {.deepest = -1};

  const StepContext<Exec, Real>& context_;
  Exec& exec_;
  OctreeBuffers<Exec> tree_;
  OctreePlanner planner_;
  ActiveLevels sent_levels_ = kNoLevels;  ///< that are on the backend
  LevelNeeds needs_;
  OctreePlan plan_;
  bool is_widened_ = false;  ///< the boxes of the step
};

}  // namespace collided
