// Benchmarks of box tests, and of what the search does with a pair of triangles.

#include "tests/bench/stages/stage_bench.hpp"
#include "tests/bench/stages/stage_bench_functors.hpp"

namespace collided::test {
namespace {

/// Tiles of 32 boxes against 32, made of the scene's triangles in Morton order: with their neighbours, or with some
/// that lie half the order away.
class Tiles {
 public:
  Tiles(StageScene& s, bool neighbours) : boxes_(s.buffers.boxes.all()), grid_(grid_over(s.step.bounds, 0, 0)) {
    const std::vector<uint32_t> order = triangles_in_order(s);
    const uint32_t tiles = static_cast<uint32_t>(order.size()) / kTile, half = tiles / 2;
    for (uint32_t i = 0; i < half; ++i) {
      leaves_.push_back({{0, 0, 0}, 0, 2 * kTile, members_.size()});
      items_.push_back({i, 0, 1});
      append(order, neighbours ? 2 * i : i);
      append(order, neighbours ? 2 * i + 1 : half + i);
    }
  }
  LeafPairs source() const { return tile_pairs(grid_, boxes_, leaves_, members_, items_, totals_); }
  uint64_t size() const { return items_.size(); }

 private:
  /// By the nodes of the hierarchy: its leaves, left or right children of the split beside them, hold the order.
  static std::vector<uint32_t> triangles_in_order(StageScene& s) {
    s.hierarchy.sort();
    s.hierarchy.join();
    std::vector<uint32_t> order;
    const BvhNode* nodes = s.hierarchy.buffers().nodes.data();
    for (uint64_t leaf = 0; leaf < s.triangles(); ++leaf) {
      const bool is_left = leaf + 1 < s.triangles() && nodes[2 * leaf].is_leaf();
      order.push_back(nodes[is_left ? 2 * leaf : 2 * leaf - 1].triangle());
    }
    return order;
  }
  void append(const std::vector<uint32_t>& order, uint32_t tile) {
    const auto first = order.begin() + tile * kTile;
    members_.insert(members_.end(), first, first + kTile);
  }

  Span<const Box<float>> boxes_;
  LevelGrid grid_;
  std::vector<Leaf> leaves_;
  std::vector<uint32_t> members_;
  std::vector<PairItem> items_;
  LeafTotals totals_{};
};

/// An item is a test of two boxes.
void bench_tiles(StageScene& s, bool neighbours, benchmark::State& state) {
  const Tiles tiles(s, neighbours);
  const LeafPairs source = tiles.source();
  uint64_t pairs = 0;
  measure(
      state, tiles.size() * kTile * kTile, [&] { pairs = 0; },
      [&] {
        LeafTiles loaded;
        run_all(tiles.size(), [&](uint64_t i) { visit_item(source, i, loaded, [&](uint32_t, uint32_t) { ++pairs; }); });
      });
  state.counters["pairs_per_tile"] = static_cast<double>(pairs) / static_cast<double>(tiles.size());
}

/// An item is a test of two boxes.
void bench_search(StageScene& s, benchmark::State& state) {
  uint64_t pairs = 0;
  const uint64_t tests = s.step.leaves[LeafSum::kTests];
  measure(
      state, tests, [&] { pairs = 0; },
      [&] { s.octree.search("count_pairs", CountPairs{&pairs}, s.state().next_item, true); });
  state.counters["tests_per_pair"] = static_cast<double>(tests) / static_cast<double>(pairs);
}

/// What becomes of the pairs of the step under a filter; an item is a pair of triangles.
template <class Keep>
void bench_features(const StageScene& s, const Keep& keep, benchmark::State& state) {
  const uint64_t vt = s.lists<VertexTriangle>().candidates.size(), ee = s.lists<EdgeEdge>().candidates.size();
  Found<uint64_t> vertex_triangle(vt), edge_edge(ee);
  const auto sink = feature_sink(s, keep, vertex_triangle, edge_edge);
  const std::vector<FeatureBoxes> features = feature_boxes(s, sink);
  const auto clear = [&] {
    vertex_triangle.clear();
    edge_edge.clear();
  };
  measure(state, s.pairs.size(), clear, [&] { take_pairs(s, sink, features); });
  const double found = static_cast<double>(vertex_triangle.count() + edge_edge.count());
  state.counters["candidates_per_pair"] = static_cast<double>(vt + ee) / static_cast<double>(s.pairs.size());
  state.counters["share_found"] = found / static_cast<double>(vt + ee);
}

}  // namespace

void register_pairs(StageScene& scene) {
  StageScene* s = &scene;
  add("pairs/tile_of_neighbours", [s](auto& state) { bench_tiles(*s, true, state); });
  add("pairs/tile_apart", [s](auto& state) { bench_tiles(*s, false, state); });
  add("pairs/search_octree", [s](auto& state) { bench_search(*s, state); });
  add("pairs/features", [s](auto& state) { bench_features(*s, KeepAll{}, state); });
  add("pairs/features_filtered", [s](auto& state) { bench_features(*s, coplanarity_filter(*s), state); });
}

}  // namespace collided::test
