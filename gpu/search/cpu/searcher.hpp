#pragma once
// The search for pairs on CPU cores: pair_search.hpp and tree_walk.hpp find them, pair_taker.hpp takes them;
// neighbour_tests.hpp tests those that are known.

#include <memory>
#include <new>
#include <utility>

#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/search/cpu/neighbour_tests.hpp"
#include "gpu/search/cpu/pair_search.hpp"
#include "gpu/search/cpu/pair_taker.hpp"
#include "gpu/search/cpu/tree_walk.hpp"
#include "gpu/search/searcher.hpp"

namespace collided {

template <>
class Searcher<CpuExec> {
 public:
  explicit Searcher(CpuExec& exec) : exec_(exec) {}

  void release() { features_ = {exec_, "features"}; }

  template <class Source, class Sink>
  void search(const char*, const Counted& items, uint64_t*, const Source& source, const Sink& sink) {
    if (source.must_rerun()) return;
    SpareTiles spare;
    share_among_takers(items.size(), 8, sink, source.boxes.size(), [&](LoopTurn& turn, auto& taker) {
      std::unique_ptr<LeafTiles> tiles = spare.take();
      while (ItemRange* left = turn.next())
        visit_some(
            source, sink, *left, *tiles, [&](uint32_t a, uint32_t b) { taker.take(a, b); },
            [&](uint32_t triangle) { taker.prefetch(triangle); });
      spare.give_back(std::move(tiles));
    });
  }

  template <class Source, class Sink>
  void walk(const char*, uint64_t items, uint64_t*, const Source& source, const Sink& sink) {
    share_among_takers(items, 64, sink, items, [&](LoopTurn& turn, auto& taker) {
      uint64_t steps = 0;
      while (ItemRange* left = turn.next())
        steps += walk_some(source, sink, *left, [&](uint32_t a, uint32_t b) { taker.take(a, b); });
      source.add_tests(steps);
    });
  }

  template <class Sink>
  void test(const char*, const Neighbours& neighbours, const Sink& sink) {
    const uint64_t first = neighbours.size(0), all = first + neighbours.size(1);
    exec_.host_loops().share(all, kNeighbours, [&](LoopTurn& turn) {
      NeighbourTester<Sink> tester(sink);
      while (ItemRange* left = turn.next()) {
        if (sink.is_over()) left->first = left->end;
        const uint64_t end = std::min(left->end, left->first + kNeighbours);
        for (; left->first < std::min(end, first); ++left->first) {
          if (left->first + kAhead < first) tester.prefetch(neighbours.first[left->first + kAhead]);
          tester.test_first(neighbours.first[left->first]);
        }
        for (; left->first < end; ++left->first) {
          if (left->first + kAhead < all) tester.prefetch(neighbours.second[left->first + kAhead - first]);
          tester.test_second(neighbours.second[left->first - first]);
        }
      }
      tester.finish();
    });
  }

 private:
  static constexpr uint64_t kNeighbours = 2048;  ///< that take a bounded time
  static constexpr uint64_t kAhead = 8;

  /// use(turn, taker), by several threads (pair_taker.hpp).
  template <class Sink, class Use>
  void share_among_takers(uint64_t items, uint64_t grain, const Sink& sink, uint64_t triangles, const Use& use) {
    const auto run = [&](const auto&... features) {
      exec_.host_loops().share(items, grain, [&](LoopTurn& turn) {
        Taker<Sink> taker(sink, features...);
        use(turn, taker);
        taker.finish();
      });
    };
    if constexpr (Sink::kTakesPairs)
      run();
    else
      run(prepare_features(sink, triangles));
  }
  template <class Sink>
  auto prepare_features(const Sink& sink, uint64_t triangles) {
    features_.ensure(triangles * sizeof(FeatureBoxes));
    FeatureBoxes* features = reinterpret_cast<FeatureBoxes*>(features_.data());
    exec_.for_each("prepare_features", triangles, [&](uint64_t i) {
      new (&features[i]) FeatureBoxes(feature_boxes_of(sink.tests, static_cast<uint32_t>(i)));
    });
    return features;
  }

  CpuExec& exec_;
  Buffer<std::byte, CpuExec> features_{exec_, "features"};  ///< FeatureBoxes of each triangle
};

}  // namespace collided
