// What becomes of pairs on CPU cores, by sinks that write down what they are asked.

#include "gpu/search/cpu/pair_taker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

namespace collided::test {
namespace {

using Candidates = std::multiset<std::tuple<uint32_t, uint32_t, int>>;

TEST(PassedTests, AreGoneThroughOnce) {
  PassedTests passed;
  Candidates found, expected;
  for (int run = 0; run < 3; ++run) {
    found.clear(), expected.clear();
    uint32_t pair = 0;
    for (; !passed.is_full(); ++pair) {
      const uint32_t tests = pair % 3 == 0 ? 0 : pair * 77 % 512;
      passed.add(pair, pair + 1, tests);
      for (int test = 0; test < 9; ++test)
        if ((tests >> test & 1) != 0) expected.insert({pair, pair + 1, test});
    }
    const uint64_t count = passed.drain([&](uint32_t a, uint32_t b, int test) { found.insert({a, b, test}); });
    EXPECT_EQ(found, expected);
    EXPECT_EQ(count, expected.size());
  }
  EXPECT_EQ(passed.drain([](uint32_t, uint32_t, int) { FAIL() << "there are none left"; }), 0u);
}

/// Keeps even candidates; keys are features, so that they can be told from the ids of triangles.
struct EvenCandidates {
  static constexpr int kFirstOfSecondKind = 6;
  static constexpr bool kTakesPairs = false, kKeepsAll = false;
  using Number = float;

  AppendList<uint64_t> vertex_triangle, edge_edge;
  Candidates* asked;
  std::vector<uint64_t>* counts;

  static uint32_t wanted_tests(ElementRole, ElementRole, bool) { return ~0u; }
  template <FirstFeature kFirst>
  bool confirms(const Box<float>&, const Box<float>&, const Stencil&, uint32_t, uint32_t) const {
    return true;
  }
  bool excludes_first(uint32_t, uint32_t, int) const { return false; }
  bool excludes_second(uint32_t, uint32_t, int) const { return false; }
  bool keeps_first(uint32_t a, uint32_t b, int test) const { return asked->insert({a, b, test}), test % 2 == 0; }
  bool keeps_second(uint32_t a, uint32_t b, int test) const { return keeps_first(a, b, test); }
  uint64_t first_key(uint32_t vertex, uint32_t triangle) const { return uint64_t{vertex} << 32 | triangle; }
  uint64_t second_key(uint32_t edge, uint32_t other) const {
    return uint64_t{std::min(edge, other)} << 32 | std::max(edge, other);
  }
  void add(uint64_t pairs, uint64_t first, uint64_t second) const { *counts = {pairs, first, second}; }
};

struct Taken {
  std::vector<uint64_t> first, second, counts;
  Candidates asked;
};

/// Two triangles whose features all meet, in one order or the other.
Taken take_pair(uint32_t a, uint32_t b) {
  const Box<float> box{{0, 0, 0}, {1, 1, 1}};
  const FeatureBoxes features[2] = {{{box, box, box}, {0, 1, 2}, {10, 11, 12}, 63},
                                    {{box, box, box}, {3, 4, 5}, {13, 14, 15}, 63}};
  Taken taken{std::vector<uint64_t>(20), std::vector<uint64_t>(20), {}, {}};
  uint64_t first = 0, second = 0;
  const EvenCandidates sink{
      {{taken.first.data(), 20}, &first}, {{taken.second.data(), 20}, &second}, &taken.asked, &taken.counts};
  CandidateTaker<EvenCandidates> taker(sink, features);
  taker.take(a, b);
  taker.finish();
  taken.first.resize(first), taken.second.resize(second);
  std::sort(taken.first.begin(), taken.first.end());
  std::sort(taken.second.begin(), taken.second.end());
  return taken;
}

TEST(CandidateTaker, AsksTheFilterWithTheLowerTriangleFirstAndKeepsWhatItSays) {
  const Taken taken = take_pair(0, 1), swapped = take_pair(1, 0);
  EXPECT_EQ(taken.counts, (std::vector<uint64_t>{1, 6, 9}));
  Candidates expected;
  for (const int test : {0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12, 14, 15, 16}) expected.insert({0, 1, test});
  EXPECT_EQ(taken.asked, expected);
  const auto key = [](uint64_t a, uint64_t b) { return a << 32 | b; };
  EXPECT_EQ(taken.first, (std::vector<uint64_t>{key(0, 1), key(2, 1), key(4, 0)}));
  EXPECT_EQ(taken.second,
            (std::vector<uint64_t>{key(10, 13), key(10, 15), key(11, 13), key(11, 15), key(12, 13), key(12, 15)}));
  EXPECT_EQ(swapped.asked, taken.asked);
  EXPECT_EQ(swapped.first, taken.first);
  EXPECT_EQ(swapped.second, taken.second);
  EXPECT_EQ(swapped.counts, taken.counts);
}

}  // namespace
}  // namespace collided::test
