#pragma once
// Shared by the stage benchmarks: groups of benchmarks over a scene, and the measuring loop.

#include <benchmark/benchmark.h>

#include <string>

#include "tests/bench/stages/stage_bench_scene.hpp"

namespace collided::test {

// Each registers a group of benchmarks; the scene outlives them.
void register_queries(StageScene& scene);
void register_octree(StageScene& scene);
void register_pairs(StageScene& scene);
void register_hierarchy(StageScene& scene);
void register_frame(StageScene& scene);
void register_sorts();  ///< of keys that are made up: no scene has that many

/// Times work(), whose result stands for `items` items; prepare() before each is not timed.
template <class Prepare, class Work>
void measure(benchmark::State& state, uint64_t items, const Prepare& prepare, const Work& work) {
  if (items == 0) return state.SkipWithError("the scene has none");
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    prepare();
    state.ResumeTiming();
    work();
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(items));
}

const auto kNoPreparation = [] {};

/// A benchmark that measures `body(state)`.
template <class Body>
void add(const std::string& name, const Body& body) {
  benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMicrosecond);
}

}  // namespace collided::test
