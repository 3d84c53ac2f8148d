// The tiles of a leaf meet each pair once, whatever the leaf's size.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "gpu/engines/octree/leaf_pairs.hpp"
#include "gpu/search/cpu/pair_search.hpp"
#include "tests/gpu/stages/octree_fixture.hpp"

namespace collided::test {
namespace {

struct OneLeaf {
  explicit OneLeaf(uint32_t n)
      : boxes(n, Box<float>{{0, 0, 0}, {1, 1, 1}}), registered(n), leaves{{{0, 0, 0}, 0, n, 0}} {
    std::iota(registered.rbegin(), registered.rend(), 0u);
    for (uint32_t row = 0; row < tiles_of(n); ++row)
      for_each_item_of_row(0, n, row, [&](uint64_t place, const PairItem& item) {
        EXPECT_EQ(place, items.size());
        items.push_back(item);
      });
  }
  LeafPairs source() {
    return {&grid,          filter,  span_of(boxes),   span_of(leaves), span_of(registered),
            span_of(items), &totals, registered.size()};
  }
  std::vector<std::pair<uint32_t, uint32_t>> pairs() {
    const LeafPairs source = this->source();
    std::vector<std::pair<uint32_t, uint32_t>> found;
    LeafTiles tiles;
    for (uint64_t i = 0; i < items.size(); ++i)
      visit_item(source, i, tiles, [&](uint32_t a, uint32_t b) { found.emplace_back(std::min(a, b), std::max(a, b)); });
    return found;
  }

  LevelGrid grid{{0, 0, 0}, 1, 0, 0};
  PairFilter filter;
  std::vector<Box<float>> boxes;
  std::vector<uint32_t> registered;
  std::vector<Leaf> leaves;
  std::vector<PairItem> items;
  LeafTotals totals{};
};

TEST(PairTests, EveryPairOfALeafOnce) {
  for (const uint32_t n :
       {1u, 2u, 3u, 4u, 5u, 31u, 32u, 33u, 63u, 64u, 65u, 127u, 128u, 129u, 256u, 257u, 289u, 700u, 4111u}) {
    OneLeaf leaf(n);
    EXPECT_EQ(leaf.items.size(), items_of(n)) << n;
    auto pairs = leaf.pairs();
    EXPECT_EQ(pairs.size(), uint64_t{n} * (n - 1) / 2) << n;
    std::sort(pairs.begin(), pairs.end());
    EXPECT_EQ(std::unique(pairs.begin(), pairs.end()), pairs.end()) << n;
    for (const auto& [a, b] : pairs) EXPECT_LT(a, b);
  }
}

TEST(PairTests, ItemsOfALargeLeafAreCountedInClosedForm) {
  for (uint32_t n = 1; n < 30000; n += 1 + n / 7) {
    uint64_t items = 0, tiles = 0;
    for (uint32_t row = 0; row < tiles_of(n); ++row)
      for_each_item_of_row(0, n, row, [&](uint64_t place, const PairItem& item) {
        ASSERT_EQ(place, items++) << n;
        tiles += std::min(tiles_of_item(n), tiles_of(n) - item.column);
      });
    ASSERT_EQ(items, items_of(n)) << n;
    ASSERT_EQ(tiles, uint64_t{tiles_of(n)} * (tiles_of(n) + 1) / 2) << n;
    ASSERT_LE(items, uint64_t{128} * tiles_of(n)) << n;
  }
}

TEST(PairTests, OnlyBoxesThatMeetAreReported) {
  OneLeaf leaf(100);
  leaf.boxes[40] = {{2, 0, 0}, {3, 1, 1}};
  leaf.boxes[41] = {{1, 1, 1}, {2, 2, 2}};  // touches all others and box 40 at the corner
  leaf.boxes[40].lo.y = 2;
  leaf.boxes[40].hi.y = 3;
  leaf.boxes[40].hi.z = 2;
  std::set<std::pair<uint32_t, uint32_t>> found;
  for (const auto& pair : leaf.pairs()) found.insert(pair);
  EXPECT_TRUE(found.contains({40, 41}));
  EXPECT_TRUE(found.contains({0, 41}));
  EXPECT_FALSE(found.contains({0, 40}));
  EXPECT_EQ(found.size(), 99u * 98u / 2 + 1);
}

TEST(PairTests, ALeafReportsThePairsThatStartInItOnAllAxes) {
  OneLeaf leaf(2);
  leaf.grid = {{0, 0, 0}, static_cast<float>(1u << kDeepest) / 8, 0, 3};  // 8 cells a side at level 3, of length 1
  leaf.leaves[0] = {{3, 3, 3}, 3, 2, 0};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> before(2, 3.9f), behind(3.9f, 5);
  int reported = 0;
  for (int run = 0; run < 2000; ++run) {
    for (Box<float>& box : leaf.boxes)
      box = {{before(random), before(random), before(random)}, {behind(random), behind(random), behind(random)}};
    const LeafPairs source = leaf.source();
    const auto work = source.work(0);
    const Box<float>&a = leaf.boxes[0], &b = leaf.boxes[1];
    const bool starts = std::min({std::max(a.lo.x, b.lo.x), std::max(a.lo.y, b.lo.y), std::max(a.lo.z, b.lo.z)}) >= 3;
    ASSERT_TRUE(overlap(a, b));
    ASSERT_EQ(starts, LeafPairs::reports(source.axes_of_start(work, a), source.axes_of_start(work, b))) << run;
    reported += starts ? 1 : 0;
  }
  EXPECT_GT(reported, 100);
}

TEST(PairFilter, FollowsGroupsMasksStaticAndSelf) {
  const std::vector<MeshRule> rules{{1, ~0u, 0, 1}, {2, 1, 0, 0}, {4, ~0u, 1, 1}, {8, ~0u, 1, 1}};
  const std::vector<uint32_t> mesh{0, 1, 2, 3};
  const PairFilter may{mesh.data(), rules.data()};
  EXPECT_TRUE(may(0, 0));
  EXPECT_TRUE(may(0, 1));
  EXPECT_FALSE(may(1, 1)) << "no self contacts";
  EXPECT_FALSE(may(1, 2)) << "mask of mesh 1 has only group 1";
  EXPECT_FALSE(may(2, 3)) << "both static";
  EXPECT_FALSE(may(2, 2)) << "static with itself";
  EXPECT_TRUE(may(0, 3));
}

/// Triangles of a few meshes with random rules.
struct RandomMeshes {
  explicit RandomMeshes(std::mt19937& random) : mesh(140) {
    const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
    for (MeshRule& rule : rules) rule = {1u << below(3), below(8), below(2), below(2)};
    const uint32_t first = below(6), count = 1 + below(3);
    for (uint32_t& m : mesh) m = std::min(first + below(count), 5u);
    if (below(2) == 0) std::sort(mesh.begin(), mesh.end());
    add_key(excluded, pack_ids(0, 1));
    add_key(excluded, pack_ids(2, 5));
  }
  PairFilter filter() const { return {mesh.data(), rules.data(), {{excluded.data(), excluded.size()}}}; }

  std::vector<MeshRule> rules = std::vector<MeshRule>(6);
  std::vector<uint32_t> mesh;
  std::vector<uint64_t> excluded = std::vector<uint64_t>(key_slots(2), kNoKey);
};

TEST(PairFilter, RulesOutTogetherOnlyWhatItRulesOutAlone) {
  std::mt19937 random(5);
  int ruled_out = 0, needless = 0;
  for (int run = 0; run < 4000; ++run) {
    const RandomMeshes meshes(random);
    const PairFilter may = meshes.filter();
    MeshesTogether p, q;
    for (uint32_t k = 0; k < 4; ++k) p.add(may.meshes_of(k)), q.add(may.meshes_of(100 + k));
    bool any = false;
    for (uint32_t a = 0; a < 4; ++a)
      for (uint32_t b = 0; b < 4; ++b) any = any || may(a, 100 + b);
    const bool together = may.may_pass(p, q);
    ASSERT_TRUE(together || !any) << run;
    ASSERT_EQ(together, may.may_pass(q, p)) << run;
    ruled_out += together ? 0 : 1;
    needless += together && !any ? 1 : 0;
  }
  EXPECT_GT(ruled_out, 1000);
  EXPECT_LT(needless, ruled_out / 4);
  EXPECT_FALSE(PairFilter{}.may_pass({}, {})) << "no triangles at all";
}

TEST(PairTests, TilesThatAreRuledOutHaveNoPairThatPasses) {
  std::mt19937 random(6);
  for (int run = 0; run < 60; ++run) {
    const RandomMeshes meshes(random);
    OneLeaf leaf(static_cast<uint32_t>(meshes.mesh.size()));
    const PairFilter may = leaf.filter = meshes.filter();
    auto pairs = leaf.pairs();
    std::sort(pairs.begin(), pairs.end());
    std::vector<std::pair<uint32_t, uint32_t>> expected;
    for (uint32_t a = 0; a < meshes.mesh.size(); ++a)
      for (uint32_t b = a + 1; b < meshes.mesh.size(); ++b)
        if (may(a, b)) expected.emplace_back(a, b);
    ASSERT_EQ(pairs, expected) << run;
  }
}

/// A leaf's source that counts the boxes that are loaded.
struct CountingSource {
  LeafPairs pairs;
  PairFilter filter = pairs.filter;
  Span<const Box<float>> boxes = pairs.boxes;
  Span<const MembersByStart> by_start = {};
  uint64_t* loads;

  auto work(uint64_t item) const { return pairs.work(item); }
  template <class Work>
  uint32_t axes_of_start(const Work& work, const Box<float>& box) const {
    ++*loads;
    return pairs.axes_of_start(work, box);
  }
};

/// One leaf with 40 members of each of many meshes that are masked from each other, and 30 of a mesh that all may
/// touch. The members are shuffled, as several threads would put them there.
struct MaskedLeaf {
  static constexpr uint32_t kMembers = 40, kOthers = 30;

  MaskedLeaf(uint32_t meshes, bool touch_themselves) : leaf(meshes * kMembers + kOthers) {
    for (uint32_t m = 0; m < meshes; ++m) {
      rules.push_back({2, 1, 0, touch_themselves ? 1u : 0u});
      mesh.insert(mesh.end(), kMembers, m);
    }
    rules.push_back({1, ~0u, 0, 0});
    mesh.insert(mesh.end(), kOthers, meshes);
    leaf.filter = {mesh.data(), rules.data()};
    std::shuffle(leaf.registered.begin(), leaf.registered.end(), std::mt19937(8));
  }

  OneLeaf leaf;
  std::vector<MeshRule> rules;
  std::vector<uint32_t> mesh;
};

TEST(PairTests, MeshesThatAreMaskedFromEachOtherAreNotEvenLoaded) {
  for (const bool touch_themselves : {false, true}) {
    constexpr uint32_t kMeshes = 100;
    MaskedLeaf masked(kMeshes, touch_themselves);
    uint64_t loads = 0;
    const CountingSource source{.pairs = masked.leaf.source(), .loads = &loads};
    std::vector<std::pair<uint32_t, uint32_t>> found, expected;
    LeafTiles tiles;
    for (uint64_t i = 0; i < masked.leaf.items.size(); ++i)
      visit_item(source, i, tiles, [&](uint32_t a, uint32_t b) { found.emplace_back(std::min(a, b), std::max(a, b)); });
    for (uint32_t a = 0; a < masked.mesh.size(); ++a)
      for (uint32_t b = a + 1; b < masked.mesh.size(); ++b)
        if (masked.leaf.filter(a, b)) expected.emplace_back(a, b);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    EXPECT_LT(loads, 6u * masked.mesh.size()) << "of " << masked.mesh.size() << " members";
  }
}

TEST(PairTests, ALargeLeafOfAnyRulesHasEveryPairOnce) {
  std::mt19937 random(9);
  for (int run = 0; run < 20; ++run) {
    const uint32_t members = 500 + static_cast<uint32_t>(random() % 1200);
    OneLeaf leaf(members);
    RandomMeshes meshes(random);
    meshes.mesh.resize(members);
    for (uint32_t& m : meshes.mesh) m = static_cast<uint32_t>(random() % 6);
    if (run % 2 == 0) std::sort(meshes.mesh.begin(), meshes.mesh.end());
    std::shuffle(leaf.registered.begin(), leaf.registered.end(), random);
    const PairFilter may = leaf.filter = meshes.filter();
    auto pairs = leaf.pairs();
    std::sort(pairs.begin(), pairs.end());
    size_t k = 0;
    for (uint32_t a = 0; a < members; ++a)
      for (uint32_t b = a + 1; b < members; ++b)
        if (may(a, b)) {
          ASSERT_LT(k, pairs.size());
          ASSERT_EQ(pairs[k++], std::pair(a, b)) << run;
        }
    EXPECT_EQ(k, pairs.size()) << run;
  }
}

// Meshes with neighbouring numbers, whose keys may not crowd each other out.
TEST(PairFilter, LeavesOutPairsOfMeshes) {
  constexpr uint32_t kMeshes = 300;
  const std::vector<MeshRule> rules(kMeshes, {1, ~0u, 0, 1});
  std::vector<uint32_t> mesh(kMeshes);
  std::iota(mesh.begin(), mesh.end(), 0u);
  const auto is_excluded = [](uint32_t a, uint32_t b) { return a != b && (a * b + a + b) % 7 < 2; };
  std::vector<uint64_t> keys;
  for (uint32_t a = 0; a < kMeshes; ++a)
    for (uint32_t b = a; b < kMeshes; ++b)
      if (is_excluded(a, b)) keys.push_back(pack_ids(a, b));
  std::vector<uint64_t> slots(key_slots(keys.size()), kNoKey);
  ASSERT_GE(slots.size(), 2 * keys.size());
  for (const uint64_t key : keys) add_key(slots, key);
  const PairFilter may{mesh.data(), rules.data(), {{slots.data(), slots.size()}}};
  for (uint32_t a = 0; a < kMeshes; ++a)
    for (uint32_t b = 0; b < kMeshes; ++b) ASSERT_EQ(may(a, b), !is_excluded(a, b)) << a << ' ' << b;
}

}  // namespace
}  // namespace collided::test
