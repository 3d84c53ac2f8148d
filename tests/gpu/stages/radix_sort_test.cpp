// Keys sorted on CPU cores against the standard library's sort.

#include "gpu/exec/cpu/radix_sort.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace collided::test {
namespace {

struct Shape {
  const char* name;
  uint64_t keys, first_ids, second_ids;
};

class Keys : public testing::TestWithParam<Shape> {
 protected:
  std::vector<uint64_t> keys() const {
    const Shape& shape = GetParam();
    std::mt19937_64 random(shape.keys);
    std::vector<uint64_t> keys(shape.keys);
    for (uint64_t& key : keys) key = random() % shape.first_ids << 32 | random() % shape.second_ids;
    return keys;
  }
};

CpuLoops loops(2);

template <class T>
Span<T> span_of(std::vector<T>& v) {
  return {v.data(), v.size()};
}

struct WriteKeys {
  Span<uint64_t> sorted;
  bool has_data() const { return false; }
  void operator()(uint64_t place, uint64_t key, uint64_t) const { sorted[place] = key; }
};

/// Keys in order, and where they came from.
struct Sorted {
  std::vector<uint64_t> keys, from;

  /// Whether keys that are alike are in the order that they were given in.
  bool keeps_order() const {
    for (size_t i = 1; i < keys.size(); ++i)
      if (keys[i] == keys[i - 1] && from[i] <= from[i - 1]) return false;
    return true;
  }
};

struct WriteBoth {
  Sorted* sorted;
  bool has_data() const { return true; }
  void operator()(uint64_t place, uint64_t key, uint64_t from) const {
    sorted->keys[place] = key;
    sorted->from[place] = from;
  }
};

std::vector<uint64_t> sorted_by(CpuLoops& loops, std::vector<uint64_t> given) {
  std::vector<uint64_t> scratch(given.size()), other(given.size()), sorted(given.size());
  const KeyArrays<WriteKeys> arrays{span_of(given), span_of(scratch), span_of(other), {span_of(sorted)}};
  RadixSort(loops, arrays).run();
  return sorted;
}

Sorted sorted_with_data(std::vector<uint64_t> given) {
  std::vector<uint64_t> scratch(given.size()), other(given.size());
  Sorted sorted{std::vector<uint64_t>(given.size()), std::vector<uint64_t>(given.size())};
  const KeyArrays<WriteBoth> arrays{span_of(given), span_of(scratch), span_of(other), {&sorted}};
  RadixSort(loops, arrays).run();
  return sorted;
}

TEST_P(Keys, AreInAscendingOrder) {
  std::vector<uint64_t> given = keys(), expected = given;
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(sorted_by(loops, given), expected);
}

TEST_P(Keys, TakeTheirDataAlong) {
  const std::vector<uint64_t> given = keys();
  std::vector<uint64_t> expected = given;
  std::sort(expected.begin(), expected.end());
  const Sorted sorted = sorted_with_data(given);
  EXPECT_EQ(sorted.keys, expected);
  for (size_t i = 0; i < given.size(); ++i) ASSERT_EQ(sorted.keys[i], given[sorted.from[i]]) << i;
  EXPECT_TRUE(sorted.keeps_order());
}

INSTANTIATE_TEST_SUITE_P(Shapes, Keys,
                         testing::Values(Shape{"none", 0, 1, 1}, Shape{"one", 1, 1, 1}, Shape{"few", 30, 100, 100},
                                         Shape{"all_zero", 70, 1, 1}, Shape{"many_zero", 300'000, 1, 1},
                                         Shape{"many", 600'000, 276'000, 138'000},
                                         Shape{"one_first_id", 50'000, 1, 1'000'000},
                                         Shape{"crowded_first_id", 300'000, 1, 1'000'000},
                                         Shape{"one_second_id", 50'000, 1'000'000, 1},
                                         Shape{"wide", 50'000, 1u << 26, 1u << 31}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(RadixSort, SortsKeysOfAllBits) {
  EXPECT_EQ(sorted_by(loops, {~uint64_t{0}, 3, uint64_t{1} << 63}),
            (std::vector<uint64_t>{3, uint64_t{1} << 63, ~uint64_t{0}}));
}

// Keys that a frame may well have: nearly all of them go to one of the first buckets.
std::vector<uint64_t> crowded_keys(uint64_t count) {
  std::mt19937_64 random(5);
  std::vector<uint64_t> keys(count);
  for (uint64_t& key : keys) key = uint64_t{77} << 32 | random() % 3'000'000;
  return keys;
}

TEST(RadixSort, DealsACrowdedBucketAgain) {
  std::vector<uint64_t> given = crowded_keys(1'000'000), expected = given;
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(sorted_by(loops, given), expected);
  const Sorted with_data = sorted_with_data(given);
  EXPECT_EQ(with_data.keys, expected);
  EXPECT_TRUE(with_data.keeps_order());
}

// Whatever the keys are, no thread sorts more than some of them without looking up.
TEST(RadixSort, LooksUpHoweverManyKeysAreOfOneFirstId) {
  const std::vector<uint64_t> given = crowded_keys(1'000'000);
  CpuLoops loop(1);
  uint64_t asked = 0;
  loop.asks.begin([&] { return ++asked == 0; }, {});
  const std::vector<uint64_t> sorted = sorted_by(loop, given);
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
  constexpr uint64_t kDeals = 2, kAtATime = 1u << 18;  // over all keys, which each counts and then moves
  EXPECT_GE(asked, 2 * kDeals * given.size() / kAtATime);
}

}  // namespace
}  // namespace collided::test
