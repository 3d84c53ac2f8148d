#pragma once
// The broad phase of small scenes: all triangles against all others, as one leaf of the octree that holds the whole
// scene. Its tables depend on the number of triangles alone, so that nothing is built in a step.

#include <vector>

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/octree/leaf_pairs.hpp"
#include "gpu/search/boxes.hpp"
#include "gpu/search/searcher.hpp"
#include "gpu/step/buffers.hpp"

namespace collided {

template <Executor Exec, class Real>
class AllPairsPhase {
 public:
  AllPairsPhase(Exec& exec, Searcher<Exec>& searcher, const SceneCounts& counts, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), searcher_(searcher), counts_(counts), scene_(scene) {}

  /// What the next steps are like.
  void begin(double thickness, bool is_ccd) { thickness_ = thickness, is_ccd_ = is_ccd; }

  void reserve() {
    AllPairsBuffers<Exec>& tables = scene_.all_pairs;
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

  /// How large the scene is.
  void measure() {
    StepState* state = scene_.state.data();
    measure_bounds(exec_, scene_.size(triangles()), PrepareNarrow{state, thickness_, scene_.deviations(is_ccd_)});
    scene_.leave_out_idle(exec_, triangles());
  }

  template <class Sink>
  void search(const char* name, const Sink& sink, uint64_t* next_item) {
    const AllPairsBuffers<Exec>& tables = scene_.all_pairs;
    const LeafPairs source{tables.grid.data(),   scene_.pair_filter(), boxes(),
                           tables.leaf.all(),    tables.members.all(), tables.items.all(),
                           tables.totals.data(), triangles()};
    searcher_.search(name, Counted{nullptr, items_of(triangles())}, next_item, source, sink);
  }

  /// The scene is the one cell, which nothing has to be registered in.
  void describe(FrameCounts& counts) const {
    const uint64_t n = triangles();
    counts.cells = counts.leaves = 1;
    counts.tests = n * (n - 1) / 2;
  }

 private:
  uint32_t triangles() const { return static_cast<uint32_t>(counts_.triangles); }
  Span<const Box<float>> boxes() const { return scene_.boxes.span(counts_.triangles); }

  template <class T>
  void put(Buffer<T, Exec>& buffer, const std::vector<T>& values) {
    buffer.allocate(values.size());
    exec_.upload(buffer.data(), values.data(), values.size() * sizeof(T));
  }

  Exec& exec_;
  Searcher<Exec>& searcher_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
  double thickness_ = 0;
  bool is_ccd_ = true;
};

}  // namespace collided
