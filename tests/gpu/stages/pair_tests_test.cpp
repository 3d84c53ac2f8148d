// The tournament of a leaf meets each pair once, whatever the leaf's size.

#include "gpu/broad/pair_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

#include "gpu/exec/cpu_exec.hpp"

namespace collided::test {
namespace {

template <class T>
Span<T> span_of(std::vector<T>& v) {
  return {v.data(), v.size()};
}

std::vector<std::pair<uint32_t, uint32_t>> pairs_of_one_leaf(uint32_t n, uint64_t capacity, uint64_t& need) {
  CpuExec exec(2, 0);
  std::vector<Box<float>> boxes(n, Box<float>{{0, 0, 0}, {1, 1, 1}});
  std::vector<Leaf> leaves{{{0, 0, 0}, 0, n}};
  std::vector<uint64_t> offsets{0, n}, units(2);
  std::vector<uint32_t> registered(n);
  std::iota(registered.rbegin(), registered.rend(), 0u);
  std::vector<TrianglePair> out(capacity);
  const LevelGrid grid{{0, 0, 0}, 1, 0, 0};
  exec.for_each("units", 2, CountPairUnits{span_of(leaves), span_of(units)});
  exec.exclusive_scan("scan", span_of(units));
  need = 0;
  exec.for_each_expanded(
      "pairs", span_of(units), units[1],
      TestPairsOfLeaf{
          grid, {}, span_of(boxes), span_of(leaves), span_of(offsets), span_of(registered), {span_of(out), &need}});
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint64_t i = 0; i < std::min<uint64_t>(need, capacity); ++i) pairs.emplace_back(out[i].a, out[i].b);
  return pairs;
}

TEST(PairTests, EveryPairOfALeafOnce) {
  for (const uint32_t n : {1u, 2u, 3u, 4u, 5u, 31u, 32u, 33u, 63u, 64u, 65u, 66u, 127u, 128u, 129u, 500u}) {
    uint64_t need = 0;
    const auto pairs = pairs_of_one_leaf(n, 200000, need);
    EXPECT_EQ(pairs.size(), uint64_t{n} * (n - 1) / 2) << n;
    EXPECT_EQ(std::set(pairs.begin(), pairs.end()).size(), pairs.size()) << n;
    for (const auto& [a, b] : pairs) EXPECT_LT(a, b);
  }
}

TEST(PairTests, AListThatIsTooSmallStillCountsTheNeed) {
  uint64_t need = 0;
  pairs_of_one_leaf(100, 10, need);
  EXPECT_EQ(need, 4950u);
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

}  // namespace
}  // namespace collided::test
