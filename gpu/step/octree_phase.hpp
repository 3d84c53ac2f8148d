#pragma once
// Steps 1 to 7 of Fig. 7: from resident positions to pairs of triangles whose boxes overlap. Everything is put in line
// for the backend; no length is read back.

#include <string>
#include <vector>

#include "gpu/base/precision.hpp"
#include "gpu/contacts/scene_counts.hpp"
#include "gpu/octree/cell_grid.hpp"
#include "gpu/octree/refine.hpp"
#include "gpu/octree/registration.hpp"
#include "gpu/octree/subdivision.hpp"
#include "gpu/search/resolution.hpp"
#include "gpu/search/searcher.hpp"
#include "gpu/step/buffers.hpp"
#include "gpu/step/plan/engine_choice.hpp"
#include "gpu/step/plan/plan.hpp"

namespace collided {

/// Side of a uniform grid's cell, and of a small cell of a two-level grid, in mean triangles. Of 1, 1.5 and 2, 1 makes
/// the fewest tests in all scenes, and the least work with them and the registrations in most.
constexpr double kCellPerMean = 1;

template <Executor Exec, class Real>
class OctreePhase {
 public:
  OctreePhase(Exec& exec, Searcher<Exec>& searcher, const SceneSpec& spec, const SceneCounts& counts,
              SceneBuffers<Exec, Real>& scene)
      : exec_(exec), searcher_(searcher), spec_(spec), counts_(counts), scene_(scene) {}

  /// What the next steps are like.
  void begin(double thickness, bool is_ccd) {
    thickness_ = thickness, is_ccd_ = is_ccd;
    narrow();
  }
  /// From here on vertices end elsewhere, and boxes are wider by the margin.
  void widen(double margin, const Vec3<Real>* end) { margin_ = round_up<Real>(margin), end_ = end; }
  /// No longer.
  void narrow() { margin_ = 0, end_ = nullptr; }

  /// Lists start at what most scenes need. Those that go together may be of different lengths since a step that ran out
  /// of memory.
  void reserve(const OctreePlan& plan) {
    const uint64_t n = triangle_count();
    const ListLengths& expected = scene_.expected;
    OctreeBuffers<Exec>& tree = scene_.octree;
    tree.wanted.allocate(1);
    if (plan.rounds > 0) {
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
    if (!has_control_bits(plan)) return;
    tree.ordered.allocate(tree.registered.capacity());
    tree.by_start.allocate(tree.leaves.capacity());
  }

  /// Makes room for what a step asked for; whether it has to run again.
  bool grow(const StepState& found) {
    OctreeBuffers<Exec>& tree = scene_.octree;
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

  /// Makes the lists of a step empty.
  void clear(const OctreePlan& plan) {
    clear_state();
    if (plan.has_octree()) exec_.fill_zero(scene_.octree.counts.data(), level_offset(plan.base + 1) * sizeof(uint32_t));
  }

  void clear_state() { exec_.fill_zero(scene_.state.data(), sizeof(StepState)); }

  // 1. Bounding boxes: of all triangles, or of meshes that move or are idle, whose boxes the last step removed.
  void box_triangles(bool all) {
    using Work = BoxTriangles<Real>;
    for (const TriangleRun& run : runs(all))
      exec_.for_each_group("box_triangles", {nullptr, (run.count + Work::kGroupSize - 1) / Work::kGroupSize},
                           Work{motion(), scene_.deviations(is_ccd_), triangles(), edges(), scene_.topology.owned.all(),
                                run.first, run.count, scene_.boxes.all(), scene_.records.all(), scene_.paths.all(),
                                scene_.triangle_inflations(), margin_, scene_.stepped_worlds()});
  }

  // Section 3.2: number of levels.
  void choose_grid(const OctreePlan& plan) {
    has_cells_of_triangles(plan.engine) ? choose_cells(plan) : choose_levels();
  }

  // 2.-5. From counts to cell-triangle pairs.
  void build(const OctreePlan& plan) {
    exec_.stage("count", [&] { count_overlapped_cells(plan); });
    if (plan.rounds > 0) exec_.stage("refine", [&] { refine(plan); });
    exec_.stage("bottom_up", [&] { cut(plan); });
    exec_.stage("top_down", [&] { place_leaves(plan); });
    exec_.stage("registration", [&] { register_triangles(plan); });
  }

  void choose_levels() {
    StepState* state = scene_.state.data();
    measure_bounds(exec_, scene_.size(triangle_count()));
    scene_.leave_out_idle(exec_, triangle_count());
    exec_.reduce_into("covered_per_level", triangle_count(), CoveredPerLevel{&state->bounds, boxes()}, LevelTotals{},
                      AddTotals{}, &state->totals,
                      PrepareStep{{&state->bounds, &state->totals, scene_.octree.wanted.data(), &state->grid},
                                  {state, thickness_, scene_.deviations(is_ccd_)}});
  }

  /// For grids whose cells are as large as the triangles.
  void choose_cells(const OctreePlan& plan) {
    StepState* state = scene_.state.data();
    const MeanExtent mean{&state->bounds, &state->extents, triangle_count()};
    LevelGrid* grid = &state->grid.grid;
    measure_bounds(exec_, scene_.size(triangle_count()));
    const auto span = [&]<class Mean>(const Mean& length) {
      return SpanCells<Mean>{&state->bounds, length, kCellPerMean, deepest_base(triangle_count()), grid};
    };
    measure_extents(exec_, scene_.size(triangle_count()), span(mean));
    scene_.leave_out_idle(exec_, triangle_count());
    if (plan.engine == Engine::kVss)  // then by those that are not large
      exec_.reduce_into("ordinary_extents", triangle_count(), OrdinaryExtentOf{mean, boxes()}, OrdinaryExtents{},
                        AddOrdinaryExtents{}, &state->ordinary, span(OrdinaryMean{&state->bounds, &state->ordinary}));
    exec_.reduce_into(
        "covered_per_level", triangle_count(), CoveredPerLevelOf{grid, boxes()}, LevelTotals{}, AddTotals{},
        &state->totals,
        ChooseCells{&state->totals, plan.engine == Engine::kTwoLevelGrid ? kLevelsOfCrowdedCell : 0, &state->grid});
    exec_.for_each("prepare_narrow", 1, PrepareNarrow{state, thickness_, scene_.deviations(is_ccd_)});
  }

  // 2. Counter octree.
  void count_overlapped_cells(const OctreePlan& plan) {
    const Span<uint32_t> counts = scene_.octree.counts.all();
    exec_.for_each_part(
        "count_overlapped_cells", all_triangles(),
        CountOverlappedCells{{grid(), boxes()}, counts, {scene_.octree.large.all(), &scene_.state.data()->large}});
    exec_.for_each_of_many_parts("count_cells_of_large", large(plan), CountCellsOfLarge{cells_of_large(), counts});
  }

  void refine(const OctreePlan& plan) {
    const Tree all = tree(plan);
    for (int round = 0; round < plan.rounds; ++round) {
      const ListInBricks list{all, round};
      if (round == 0) {
        exec_.for_each("open_first_bricks", base_cells(plan), OpenFirstBricks{all});
        exec_.for_each_part("list_in_first_bricks", all_triangles(), ListInFirstBricks{list, {grid(), boxes()}});
        exec_.for_each_of_many_parts("list_large_in_first_bricks", large(plan),
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
  void cut(const OctreePlan& plan) {
    const Tree all = tree(plan);
    if (plan.engine == Engine::kTwoLevelGrid) return exec_.for_each("cut_crowded", top_cells(), CutCrowded{all});
    for (int round = plan.rounds - 1; round >= 0; --round)
      exec_.for_each_group("cut_bricks", bricks(round), CutBricks{all, plan.cost, round});
    for (int step = 0; step * kBrickLevels < max(1, plan.levels - 1); ++step)
      exec_.for_each_group("cut_dense", roots(plan, step),
                           CutDense{all, plan.cost, scene_.octree.root_cost.all(), step});
  }

  // 4. Top-down stage: the leaves of the cut and their places.
  void place_leaves(const OctreePlan& plan) {
    OctreeBuffers<Exec>& octree = scene_.octree;
    const PlaceLeaves place{
        tree(plan),         octree.leaves.all(),          octree.cursor.all(), octree.registered.capacity(),
        octree.items.all(), &scene_.state.data()->leaves, scene_.share.data()};
    exec_.for_each_group("place_dense_leaves", cell_groups(plan), PlaceDenseLeaves{place});
    for (int round = 0; round < plan.rounds; ++round)
      exec_.for_each_group("place_brick_leaves", bricks(round), PlaceBrickLeaves{place, round});
  }

  // 5. Cell-triangle pairs.
  void register_triangles(const OctreePlan& plan) {
    OctreeBuffers<Exec>& octree = scene_.octree;
    const Registration registration{tree(plan), octree.cursor.all(), octree.registered.all()};
    exec_.for_each_part("register_triangles", all_triangles(),
                        RegisterTriangles<CellsOfTriangles>{registration, {grid(), boxes()}});
    exec_.for_each_of_many_parts("register_large", large(plan),
                                 RegisterTriangles<CellsOfLarge>{registration, cells_of_large()});
    for (int round = 0; round < plan.rounds; ++round)
      exec_.for_each_part("register_in_bricks", brick_items(round),
                          RegisterTriangles<CellsInBricks>{registration, {registration.tree, boxes(), round}});
    if (!has_control_bits(plan)) return;
    const Counted leaves{&scene_.state.data()->leaves[LeafSum::kLeaves], octree.leaves.capacity()};
    exec_.for_each_group("order_by_control_bits", leaves,
                         OrderByControlBits{leaf_pairs(plan, octree.registered.all()), octree.ordered.all(),
                                            octree.by_start.all(), &scene_.state.data()->leaves});
  }

  // 6.-7. Broad-phase tests, spread evenly; what they find goes to the sink.
  template <class Sink>
  void search(const char* name, const OctreePlan& plan, const Sink& sink, uint64_t* next_item) {
    StepState* state = scene_.state.data();
    const OctreeBuffers<Exec>& octree = scene_.octree;
    LeafPairs source = leaf_pairs(plan, octree.registered.all());
    if (has_control_bits(plan)) source.registered = octree.ordered.all(), source.by_start = octree.by_start.all();
    searcher_.search(name, Counted{&state->leaves[LeafSum::kItems], octree.items.capacity()}, next_item, source, sink);
  }

  /// Counts the triangles that the spacing of the positions' numbers is too coarse for.
  void count_small_triangles() {
    exec_.for_each("count_small_triangles", triangle_count(),
                   CountSmall<Real>{&scene_.state.data()->bounds, scene_.triangle_records(),
                                    &scene_.state.data()->small_triangles, scene_.stepped_worlds()});
  }
  /// After a step: whether the spacing of the positions' numbers, at the largest of them, is coarser than delta;
  /// without a delta, than a thousandth of most triangles.
  bool is_coarse(const StepState& step, const FrameSettings& settings) const {
    if (settings.delta > 0) return spacing_at<Real>(step.bounds) > settings.delta;
    const uint64_t judged = counts_.triangles - counts_.loose_points;
    const uint64_t worlds = max(counts_.worlds, 1u), stepped = counts_.worlds > 0 ? scene_.worlds.stepped : 1;
    return 2 * step.small_triangles > judged / worlds * stepped;
  }

  ElementaryTests<Real> elementary(const PerKind<bool>& wanted) const {
    return {scene_.triangle_records(),
            scene_.topology.owned.all(),
            {widened(motion().inflation, margin_)},
            wanted.vertex_triangle,
            wanted.edge_edge};
  }
  /// The same where boxes are inflated by more in some meshes, or some elements are no triangles.
  ElementaryTests<Real, InflationByTriangle<Real>, MixedElements> elementary_of_any(const PerKind<bool>& wanted) const {
    return {scene_.triangle_records(),
            scene_.topology.owned.all(),
            {widened(motion().inflation, margin_), scene_.triangle_inflations()},
            wanted.vertex_triangle,
            wanted.edge_edge};
  }

 private:
  uint64_t triangle_count() const { return counts_.triangles; }
  uint32_t dense_cells() const { return level_offset(deepest_base(triangle_count()) + 1); }
  Span<const Box<float>> boxes() const { return scene_.boxes.span(triangle_count()); }
  WorldTable<Triangle> triangles() const { return scene_.topology.corners(); }
  WorldTable<Triangle> edges() const { return scene_.topology.sides(); }
  const LevelGrid* grid() const { return &scene_.state.data()->grid.grid; }
  static bool has_control_bits(const OctreePlan& plan) { return plan.engine == Engine::kVss; }
  LeafPairs leaf_pairs(const OctreePlan& plan, Span<const uint32_t> registered) const {
    const OctreeBuffers<Exec>& octree = scene_.octree;
    return {grid(),
            scene_.pair_filter(),
            boxes(),
            octree.leaves.all(),
            registered,
            octree.items.all(),
            &scene_.state.data()->leaves,
            octree.registered.capacity(),
            &scene_.state.data()->totals,
            plan.max_crowded_tests};
  }
  CellsOfLarge cells_of_large() const { return {grid(), boxes(), scene_.octree.large.all()}; }

  /// Triangles [first, first + count).
  struct TriangleRun {
    uint64_t first, count;
  };
  std::vector<TriangleRun> runs(bool all) const {
    if (counts_.worlds > 0) return {{0, triangle_count()}};  // whichever are static
    std::vector<TriangleRun> runs;
    for (uint32_t mesh = 0; mesh < spec_.meshes.size(); ++mesh) {
      const bool is_boxed = spec_.meshes[mesh].motion == MeshMotion::kStatic && !scene_.topology.idle.has(mesh);
      if (!all && is_boxed) continue;
      const uint64_t first = counts_.triangle_offset[mesh], end = counts_.triangle_offset[mesh + 1];
      if (!runs.empty() && runs.back().first + runs.back().count == first)
        runs.back().count += end - first;
      else
        runs.push_back({first, end - first});
    }
    return runs;
  }

  // Lengths, and bounds that the host knows: blocks of which most have nothing to do take their time too.
  Counted large(const OctreePlan& plan) const {
    return {&scene_.state.data()->large, plan.has_large ? scene_.octree.large.capacity() : 0};
  }
  Counted base_cells(const OctreePlan& plan) const {
    return {&scene_.state.data()->grid.base_cells, uint64_t{1} << (3 * plan.base)};
  }
  Counted top_cells() const { return {&scene_.state.data()->grid.top_cells, dense_cells()}; }
  Counted cell_groups(const OctreePlan& plan) const {
    return {&scene_.state.data()->grid.cell_groups, groups_of_cells({{}, 0, 0, plan.base})};
  }
  Counted roots(const OctreePlan& plan, int step) const {
    return {&scene_.state.data()->grid.roots[step], roots_of_step({{}, 0, 0, plan.base}, step)};
  }
  Counted bricks(int round) const { return {&scene_.state.data()->bricks[round], scene_.octree.bricks.capacity()}; }

  Counted brick_items(int round) const {
    return {&scene_.state.data()->brick_items[round], scene_.octree.brick_items.capacity()};
  }
  Counted all_triangles() const { return {nullptr, triangle_count()}; }

  Tree tree(const OctreePlan& plan) const {
    OctreeBuffers<Exec>& octree = scene_.octree;
    return {grid(),
            dense_cells(),
            octree.counts.all(),
            octree.type.all(),
            octree.slot.all(),
            octree.bricks.all(),
            octree.reach.all(),
            octree.brick_cost.all(),
            octree.brick_items.all(),
            scene_.state.data()->bricks,
            scene_.state.data()->brick_items,
            plan.rounds};
  }

  Motion<Real> motion() const {
    const Real half = static_cast<Real>(thickness_) / 2;
    return {scene_.positions_at_start(is_ccd_), end_ != nullptr ? end_ : scene_.end.data(),
            half == 0 ? half : next_up(half)};
  }

  static void check_length(const std::string& list, uint64_t need) {
    if (need >= ~0u)
      throw ResourceExhausted("the octree needs " + std::to_string(need) + " " + list + ", the limit is " +
                              std::to_string(~0u - 1));
  }
  void reserve_leaves(uint64_t count) {
    scene_.octree.leaves.allocate(count);
    scene_.octree.cursor.allocate(count);
  }
  void reserve_bricks(uint64_t count) {
    OctreeBuffers<Exec>& tree = scene_.octree;
    tree.bricks.allocate(count);
    tree.reach.allocate(count);
    tree.brick_cost.allocate(count);
    reserve_cells();
  }
  void reserve_cells() {
    OctreeBuffers<Exec>& tree = scene_.octree;
    const uint64_t cells = dense_cells() + tree.bricks.capacity() * kBrickCells;
    tree.counts.allocate(cells);
    tree.type.allocate(cells);
    tree.slot.allocate(cells);
  }

  Exec& exec_;
  Searcher<Exec>& searcher_;
  const SceneSpec& spec_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
  double thickness_ = 0;
  bool is_ccd_ = true;
  Real margin_ = 0;
  const Vec3<Real>* end_ = nullptr;  ///< null: where the scene's vertices do
};

}  // namespace collided
