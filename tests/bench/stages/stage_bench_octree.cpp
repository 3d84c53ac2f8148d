// Benchmarks of the stages from boxes to registered triangles; an item is a triangle unless said otherwise. Each leaves
// the octree unchanged, so that any of them can run alone.

#include <algorithm>
#include <numeric>

#include "tests/bench/stages/stage_bench.hpp"

namespace collided::test {
namespace {

void bench_boxes(StageScene& s, benchmark::State& state) {
  measure(state, s.triangles(), kNoPreparation, [&] { s.boxes.box_triangles(true); });
}

void bench_levels(StageScene& s, benchmark::State& state) {
  measure(state, s.triangles(), kNoPreparation, [&] { s.octree.choose_levels(); });
}

void bench_count(StageScene& s, benchmark::State& state) {
  measure(
      state, s.triangles(),
      [&] {
        s.state().large = 0;
        s.octree.clear();
      },
      [&] { s.octree.count_overlapped_cells(); });
  const LevelGrid& grid = s.step.grid.grid;
  const uint32_t* counts = s.octree.buffers().counts.data();
  const uint64_t all =
      std::accumulate(counts + level_offset(grid.top), counts + level_offset(grid.base + 1), uint64_t{0});
  state.counters["counts_per_triangle"] = static_cast<double>(all) / static_cast<double>(s.triangles());
}
void bench_refine(StageScene& s, benchmark::State& state) {
  const auto clear = [&] {
    std::fill_n(s.state().bricks, kMaxRounds, uint64_t{0});
    std::fill_n(s.state().brick_items, kMaxRounds, uint64_t{0});
  };
  measure(state, s.triangles(), clear, [&] { s.octree.refine(); });
}

/// An item is an active dense cell.
void bench_cut(StageScene& s, benchmark::State& state) {
  const LevelGrid& grid = s.step.grid.grid;
  const uint64_t cells = level_offset(grid.base + 1) - level_offset(grid.top);
  measure(state, cells, kNoPreparation, [&] { s.octree.cut(); });
}

void clear_leaves(StageScene& s) { s.state().leaves = {}; }

/// An item is a leaf.
void bench_place(StageScene& s, benchmark::State& state) {
  measure(
      state, s.step.leaves[LeafSum::kLeaves], [&] { clear_leaves(s); }, [&] { s.octree.place_leaves(); });
}

/// An item is a registration.
void bench_register(StageScene& s, benchmark::State& state) {
  const auto place = [&] {
    clear_leaves(s);
    s.octree.place_leaves();
  };
  measure(state, s.step.leaves[LeafSum::kRegistrations], place, [&] { s.octree.register_triangles(); });
}

}  // namespace

void register_octree(StageScene& scene) {
  StageScene* s = &scene;
  add("boxes/box_triangles", [s](auto& state) { bench_boxes(*s, state); });
  add("octree/choose_levels", [s](auto& state) { bench_levels(*s, state); });
  add("octree/count_cells", [s](auto& state) { bench_count(*s, state); });
  if (s->plan.octree.rounds > 0) add("octree/refine", [s](auto& state) { bench_refine(*s, state); });
  add("octree/cut", [s](auto& state) { bench_cut(*s, state); });
  add("octree/place_leaves", [s](auto& state) { bench_place(*s, state); });
  add("octree/register", [s](auto& state) { bench_register(*s, state); });
}

}  // namespace collided::test
