#pragma once
// The broad phase of small scenes: all triangles against all others, as one leaf of the octree that holds the whole
// scene. Its tables depend on the number of triangles alone, so that nothing is built in a step.

#include <vector>

#include "gpu/engines/broad_phase.hpp"
#include "gpu/engines/octree/leaf_pairs.hpp"

namespace collided {

/// The scene as one leaf: what the search for all pairs goes by. It changes with the number of triangles alone.
template <Executor Exec>
struct AllPairsBuffers {
  explicit AllPairsBuffers(Exec& exec)
      : leaf(exec, "all_pairs"),
        totals(exec, "all_pairs"),
        grid(exec, "all_pairs"),
        members(exec, "all_pairs"),
        items(exec, "all_pairs") {}

  uint32_t triangles = 0;  ///< that the tables are of
  Buffer<Leaf, Exec> leaf;
  Buffer<LeafTotals, Exec> totals;
  Buffer<LevelGrid, Exec> grid;
  Buffer<uint32_t, Exec> members;
  Buffer<PairItem, Exec> items;
};

template <Executor Exec, class Real>
class AllPairsPhase : public BroadPhaseDefaults {
 public:
  static constexpr Engine kEngine = Engine::kAllPairs;
  static constexpr bool serves(Engine engine) { return engine == kEngine; }

  explicit AllPairsPhase(const StepContext<Exec, Real>& context) : context_(context), tables_(context.exec) {}

  void begin(const StepPlan& step) { needs_ = step.needs; }
  void reserve() {
    AllPairsBuffers<Exec>& tables = tables_;
    if (tables.triangles == triangles()) return;
    tables.triangles = 0;  // until all is there
    std::vector<uint32_t> members(triangles());
    for (uint32_t i = 0; i < members.size(); ++i) members[i] = i;
    std::vector<PairItem> items(items_of(triangles()));
    for (uint32_t row = 0; row < tiles_of(triangles()); ++row)
      for_each_item_of_row(0, triangles(), row, [&](uint64_t place, const PairItem& item) { items[place] = item; });
    put(tables.leaf, std::vector{Leaf{{0, 0, 0}, 0, triangles(), 0}});
    put(tables.totals, std::vector{LeafTotals{}});
    put(tables.grid, std::vector{LevelGrid{}});
    put(tables.members, members);
    put(tables.items, items);
    tables.triangles = triangles();
  }

  void measure() { context_.measure_bounds_alone(needs_); }

  template <class Sink>
  void search(const char* name, const Sink& sink, uint64_t* next_item, bool) {
    const LeafPairs source{
        tables_.grid.data(),   context_.scene.pair_filter(), context_.boxes(),      tables_.leaf.all(),
        tables_.members.all(), tables_.items.all(),          tables_.totals.data(), triangles()};
    context_.searcher.search(name, Counted{nullptr, items_of(triangles())}, next_item, source, sink);
  }

  /// The scene is the one cell, which nothing has to be registered in.
  void finish(const StepState&, FrameCounts& counts) const {
    const uint64_t n = triangles();
    counts.cells = counts.leaves = 1;
    counts.tests = n * (n - 1) / 2;
  }

  bool holds_memory() const { return tables_.triangles > 0; }
  void release() { tables_ = AllPairsBuffers<Exec>(context_.exec); }

 private:
  uint32_t triangles() const { return static_cast<uint32_t>(context_.triangles()); }

  template <class T>
  void put(Buffer<T, Exec>& buffer, const std::vector<T>& values) {
    buffer.allocate(values.size());
    context_.exec.upload(buffer.data(), values.data(), values.size() * sizeof(T));
  }

  const StepContext<Exec, Real>& context_;
  AllPairsBuffers<Exec> tables_;
  LevelNeeds needs_;
};

}  // namespace collided
