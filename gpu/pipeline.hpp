#pragma once
// The paper's Fig. 7 for one frame: positions that are resident in, contacts in canonical order out.
// detect_contacts() at the end names the steps in their order; a scene runs those that its spec requires.

#include <utility>
#include <vector>

#include "gpu/broad/pair_tests.hpp"
#include "gpu/broad/resolution.hpp"
#include "gpu/narrow_phase.hpp"
#include "gpu/octree/levels.hpp"
#include "gpu/octree/registration.hpp"
#include "gpu/octree/top_down.hpp"
#include "gpu/scene_buffers.hpp"

namespace collided {

/// Triangles [first, first + count) whose boxes are out of date.
struct TriangleRun {
  uint64_t first, count;
};

template <class Exec, class Real>
class Pipeline {
 public:
  Pipeline(Exec& exec, const SceneSpec& spec, const Topology& topology, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), spec_(spec), topology_(topology), scene_(scene), narrow_(exec, spec, scene) {}

  /// Fig. 7.
  FrameResult detect_contacts(const std::vector<TriangleRun>& moved, const FrameSettings& settings) {
    result_ = {};
    exec_.stage("boxes", [&] { box_triangles(moved); });
    exec_.stage("levels", [&] { choose_levels(settings); });
    exec_.stage("count", [&] { count_overlapped_cells(); });
    exec_.stage("bottom_up", [&] { bottom_up(exec_, grid_, counts(), cost(), type()); });
    exec_.stage("top_down", [&] { find_leaves(); });
    exec_.stage("registration", [&] { register_triangles(); });
    exec_.stage("pair_tests", [&] { test_pairs(); });
    narrow_.begin(settings, extent_, result_);
    if (spec_.vertex_triangle) detect_vertex_triangle();
    if (spec_.edge_edge && !narrow_.is_over()) detect_edge_edge();
    if (spec_.triangle_triangle && !narrow_.is_over()) narrow_.detect_triangles(pairs());
    narrow_.finish();
    finish();
    return std::move(result_);
  }

 private:
  uint64_t triangle_count() const { return topology_.triangles.size(); }
  Span<const Box<float>> boxes() const { return scene_.boxes.span(triangle_count()); }
  uint32_t first_cell() const { return level_offset(grid_.top); }
  uint64_t active_cells() const { return level_offset(grid_.base + 1) - first_cell(); }
  Span<uint32_t> counts() const { return scene_.octree.counts.all(); }
  Span<uint64_t> cost() const { return scene_.octree.cost.all(); }
  Span<uint8_t> type() const { return scene_.octree.type.all(); }
  Span<uint32_t> slot() const { return scene_.octree.slot.span(active_cells() + 1); }
  Span<const uint64_t> units() const { return scene_.octree.units.span(triangle_count() + 1); }
  Span<Leaf> leaves() const { return scene_.octree.leaves.span(result_.counts.leaves); }
  Span<uint64_t> offsets() const { return scene_.octree.offsets.span(result_.counts.leaves + 1); }

  Motion<Real> motion() const {
    const Vec3<Real>* end = scene_.end.data();
    const Real half = static_cast<Real>(spec_.thickness) / 2;
    return {spec_.mode == Mode::kCcd ? scene_.start.data() : end, end, half == 0 ? half : next_up(half)};
  }
  Span<const Triangle> triangles() const { return scene_.topology.triangles.span(triangle_count()); }
  VertexTriangle vertex_triangle() const { return {triangles()}; }
  EdgeEdge edge_edge() const { return {scene_.topology.edges.span(topology_.edges.size())}; }

  // 1. Bounding boxes.
  void box_triangles(const std::vector<TriangleRun>& moved) {
    for (const TriangleRun& run : moved)
      exec_.for_each("box_triangles", run.count,
                     BoxTriangles<Real>{motion(), triangles(), run.first, scene_.boxes.span(triangle_count())});
  }

  // Section 3.2: number of levels. Two read-backs: the bounds, the registrations each level would take.
  void choose_levels(const FrameSettings& settings) {
    const Box<float> bounds = exec_.reduce("bounds", triangle_count(), BoxOf{boxes()}, empty_box(), JoinBoxes{});
    const Vec3<float> extent = bounds.hi - bounds.lo;
    extent_ = larger(extent.x, larger(extent.y, extent.z));
    if (settings.accuracy >= Accuracy::kGuarded) result_.input_resolution = is_coarse(bounds, settings.delta);
    const LevelTotals totals =
        exec_.reduce("covered_per_level", triangle_count(), CoveredPerLevel{grid_over(bounds, 0, kMaxLevel), boxes()},
                     LevelTotals{}, AddTotals{});
    levels_ = clamp_levels(levels_, totals, triangle_count());
    grid_ = grid_over(bounds, levels_.top, levels_.base);
  }

  // 2. Counter octree.
  void count_overlapped_cells() {
    OctreeBuffers<Exec>& tree = scene_.octree;
    const uint64_t end_cell = level_offset(grid_.base + 1);
    tree.counts.allocate(end_cell);
    tree.cost.allocate(end_cell);
    tree.type.allocate(end_cell);
    tree.slot.allocate(end_cell + 1);
    tree.units.allocate(triangle_count() + 1);
    exec_.fill_zero(tree.counts.data() + first_cell(), active_cells() * sizeof(uint32_t));
    const Span<uint64_t> covered = tree.units.span(triangle_count() + 1);
    exec_.for_each("count_covered_cells", covered.size(), CountCoveredCells{grid_, boxes(), covered});
    exec_.exclusive_scan("scan_covered_cells", covered);
    covered_total_ = exec_.read(covered.data + triangle_count());
    exec_.for_each_expanded("count_overlapped_cells", units(), covered_total_,
                            CountOverlappedCells{grid_, boxes(), counts()});
    result_.counts.cells =
        exec_.reduce("non_empty_cells", active_cells(), IsNonEmpty{first_cell(), counts()}, uint64_t{0}, Add{});
  }

  // 4. Top-down stage: the leaves of the cut and their places.
  void find_leaves() {
    OctreeBuffers<Exec>& tree = scene_.octree;
    exec_.for_each("mark_real_leaves", slot().size(), MarkRealLeaves{grid_.top, first_cell(), type(), slot()});
    exec_.exclusive_scan("scan_leaves", slot());
    result_.counts.leaves = exec_.read(slot().data + active_cells());
    tree.leaves.ensure(result_.counts.leaves);
    tree.offsets.ensure(result_.counts.leaves + 1);
    tree.leaf_units.ensure(result_.counts.leaves + 1);
    tree.cursor.ensure(result_.counts.leaves);
    tree.level_registrations.allocate(kMaxLevel + 1);
    exec_.fill_zero(tree.level_registrations.data(), (kMaxLevel + 1) * sizeof(uint64_t));
    exec_.for_each(
        "write_leaves", active_cells(),
        WriteLeaves{first_cell(), slot(), counts(), leaves(), offsets(), tree.level_registrations.span(kMaxLevel + 1)});
    exec_.fill_zero(offsets().data + result_.counts.leaves, sizeof(uint64_t));
    exec_.exclusive_scan("scan_registrations", offsets());
    result_.counts.registrations = exec_.read(offsets().data + result_.counts.leaves);
    result_.counts.tests = exec_.reduce("tests", result_.counts.leaves, TestsOfLeaf{leaves()}, uint64_t{0}, Add{});
  }

  // 5. Cell-triangle pairs.
  void register_triangles() {
    OctreeBuffers<Exec>& tree = scene_.octree;
    tree.registered.ensure(result_.counts.registrations);
    exec_.fill_zero(tree.cursor.data(), result_.counts.leaves * sizeof(uint32_t));
    exec_.for_each_expanded(
        "register_triangles", units(), covered_total_,
        RegisterTriangles{grid_, first_cell(), boxes(), slot(), offsets(), tree.cursor.span(result_.counts.leaves),
                          tree.registered.span(result_.counts.registrations)});
  }

  // 6.-7. Broad-phase tests, spread evenly.
  void test_pairs() {
    const Span<uint64_t> units = scene_.octree.leaf_units.span(result_.counts.leaves + 1);
    exec_.for_each("count_pair_units", units.size(), CountPairUnits{leaves(), units});
    exec_.exclusive_scan("scan_pair_units", units);
    const uint64_t total = exec_.read(units.data + result_.counts.leaves);
    result_.counts.pairs = fill(scene_.pairs, [&](const AppendList<TrianglePair>& pairs) {
      exec_.for_each_expanded("test_pairs", units, total,
                              TestPairsOfLeaf{grid_, filter(), boxes(), leaves(), offsets(),
                                              scene_.octree.registered.span(result_.counts.registrations), pairs});
    });
  }
  PairFilter filter() const { return {scene_.topology.mesh_of_triangle.data(), scene_.topology.rules.data()}; }
  Span<const TrianglePair> pairs() const { return scene_.pairs.span(result_.counts.pairs); }
  Ownership owned() const { return {scene_.topology.owned.span(triangle_count())}; }

  /// Whether the spacing of the positions' numbers, at the largest of them, is coarser than delta; without a delta,
  /// than a thousandth of most triangles.
  bool is_coarse(const Box<float>& bounds, double delta) {
    const Real spacing = spacing_at<Real>(bounds);
    if (delta > 0) return spacing > delta;
    const uint64_t small =
        exec_.reduce("count_small_triangles", triangle_count(),
                     IsSmall<Real>{scene_.end.data(), triangles(), 1024 * spacing}, uint64_t{0}, Add{});
    return 2 * small > triangle_count();
  }

  // 7.-8. Elementary tests and narrow phase, one kind at a time.
  void detect_vertex_triangle() {
    exec_.stage("elementary_vt", [&] { find_vertex_triangle(); });
    narrow_.detect(vertex_triangle(), scene_.candidates.span(result_.counts.candidates_vt));
  }
  void find_vertex_triangle() {
    result_.counts.candidates_vt = fill(scene_.candidates, [&](const AppendList<uint64_t>& out) {
      exec_.for_each("find_vertex_triangle_pairs", result_.counts.pairs,
                     FindVertexTrianglePairs<Real>{motion(), triangles(), owned(), pairs(), out});
    });
  }
  void detect_edge_edge() {
    exec_.stage("elementary_ee", [&] { find_edge_edge(); });
    narrow_.detect(edge_edge(), scene_.candidates.span(result_.counts.candidates_ee));
  }
  void find_edge_edge() {
    const Span<const Triangle> edges = scene_.topology.triangle_edges.span(triangle_count());
    result_.counts.candidates_ee = fill(scene_.candidates, [&](const AppendList<uint64_t>& out) {
      exec_.for_each("find_edge_edge_pairs", result_.counts.pairs,
                     FindEdgeEdgePairs<Real>{motion(), triangles(), edges, owned(), pairs(), out});
    });
  }

  template <class T, class Run>
  uint64_t fill(Buffer<T, Exec>& list, const Run& run) {
    return fill_list(exec_, list, scene_.list_count, result_.replays, run);
  }

  void finish() {
    uint64_t registrations[kMaxLevel + 1];
    exec_.download(registrations, scene_.octree.level_registrations.data(), sizeof(registrations));
    result_.counts.top_level = static_cast<uint32_t>(levels_.top);
    result_.counts.base_level = static_cast<uint32_t>(levels_.base);
    levels_ = next_levels(levels_, registrations);
    result_.stages = exec_.stage_times();
  }

  Exec& exec_;
  const SceneSpec& spec_;
  const Topology& topology_;
  SceneBuffers<Exec, Real>& scene_;
  NarrowPhase<Exec, Real> narrow_;
  ActiveLevels levels_;
  LevelGrid grid_{};
  float extent_ = 0;  ///< largest of the scene's bounds
  uint64_t covered_total_ = 0;
  FrameResult result_;
};

}  // namespace collided
