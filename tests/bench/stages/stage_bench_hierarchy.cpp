// Benchmarks of the stages of the bounding volume hierarchy; an item is a triangle unless said otherwise.

#include "tests/bench/stages/stage_bench.hpp"
#include "tests/bench/stages/stage_bench_functors.hpp"

namespace collided::test {
namespace {

void make_keys(StageScene& s) { s.exec.for_each("morton_keys", s.triangles(), morton_keys(s)); }

void bench_keys(StageScene& s, benchmark::State& state) {
  measure(state, s.triangles(), kNoPreparation, [&] { make_keys(s); });
}

void bench_sort(StageScene& s, benchmark::State& state) {
  const BvhBuffers<CpuExec>& bvh = s.hierarchy.buffers();
  const SortArrays arrays{bvh.keys[0].all(), bvh.keys[1].all(), bvh.triangles[0].all(), bvh.triangles[1].all()};
  measure(
      state, s.triangles(), [&] { make_keys(s); }, [&] { s.exec.sort_pairs("sort", MortonKeys::kBits, arrays); });
}

void bench_build(StageScene& s, benchmark::State& state) {
  measure(
      state, s.triangles(), [&] { s.hierarchy.sort(); }, [&] { s.hierarchy.join(); });
}

/// An item is a box that a walk meets.
void bench_walk(StageScene& s, benchmark::State& state) {
  s.hierarchy.sort();
  s.hierarchy.join();
  s.state().leaves[LeafSum::kTests] = 0;
  uint64_t pairs = 0;
  const auto walk = [&] { s.hierarchy.search("count_pairs", CountPairs{&pairs}, s.state().next_item, true); };
  walk();  // the first one counts what it meets
  const uint64_t tests = s.state().leaves[LeafSum::kTests];
  measure(
      state, tests, [&] { pairs = 0; }, walk);
  state.counters["tests_per_pair"] = static_cast<double>(tests) / static_cast<double>(pairs);
}

}  // namespace

void register_hierarchy(StageScene& scene) {
  StageScene* s = &scene;
  add("hierarchy/morton_keys", [s](auto& state) { bench_keys(*s, state); });
  add("hierarchy/sort", [s](auto& state) { bench_sort(*s, state); });
  add("hierarchy/build", [s](auto& state) { bench_build(*s, state); });
  add("hierarchy/walk", [s](auto& state) { bench_walk(*s, state); });
}

}  // namespace collided::test
