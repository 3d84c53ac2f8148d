// Keys sorted on CPU cores against the standard library's sort.

#include "gpu/exec/cpu/key_order.hpp"

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

struct WriteBoth {
  Span<const uint64_t> data;
  Span<uint64_t> sorted, along;
  bool has_data() const { return true; }
  void operator()(uint64_t place, uint64_t key, uint64_t from) const {
    sorted[place] = key;
    along[place] = data[from];
  }
};

std::vector<uint64_t> sorted_by(CpuLoops& loops, std::vector<uint64_t> given) {
  std::vector<uint64_t> scratch(given.size()), other(given.size()), sorted(given.size());
  const KeyArrays<WriteKeys> arrays{span_of(given), span_of(scratch), span_of(other), {span_of(sorted)}};
  KeyOrder(loops, arrays).run();
  return sorted;
}

TEST_P(Keys, AreInAscendingOrder) {
  std::vector<uint64_t> given = keys(), expected = given;
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(sorted_by(loops, given), expected);
}

TEST_P(Keys, TakeTheirDataAlong) {
  std::vector<uint64_t> given = keys(), data = given, scratch(given.size()), other(given.size()), sorted(given.size()),
                        along(given.size());
  for (uint64_t& d : data) d ^= 0x5555;
  const KeyArrays<WriteBoth> arrays{
      span_of(given), span_of(scratch), span_of(other), {span_of(data), span_of(sorted), span_of(along)}};
  KeyOrder(loops, arrays).run();
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
  for (size_t i = 0; i < along.size(); ++i) ASSERT_EQ(along[i], sorted[i] ^ 0x5555) << i;
}

INSTANTIATE_TEST_SUITE_P(Shapes, Keys,
                         testing::Values(Shape{"none", 0, 1, 1}, Shape{"one", 1, 1, 1}, Shape{"few", 30, 100, 100},
                                         Shape{"all_zero", 70, 1, 1}, Shape{"many", 600'000, 276'000, 138'000},
                                         Shape{"one_first_id", 50'000, 1, 1'000'000},
                                         Shape{"crowded_first_id", 300'000, 1, 1'000'000},
                                         Shape{"one_second_id", 50'000, 1'000'000, 1},
                                         Shape{"wide", 50'000, 1u << 26, 1u << 31}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(KeyOrder, SortsKeysOfAllBits) {
  EXPECT_EQ(sorted_by(loops, {~uint64_t{0}, 3, uint64_t{1} << 63}),
            (std::vector<uint64_t>{3, uint64_t{1} << 63, ~uint64_t{0}}));
}

// Keys that a frame may well have: whatever they are, no thread sorts more than some of them without looking up.
TEST(KeyOrder, LooksUpHoweverManyKeysAreOfOneFirstId) {
  std::mt19937_64 random(5);
  std::vector<uint64_t> given(1'000'000);
  for (uint64_t& key : given) key = uint64_t{77} << 32 | random() % 3'000'000;
  CpuLoops loop(1);
  uint64_t asked = 0;
  loop.asks.begin([&] { return ++asked == 0; }, {});
  const std::vector<uint64_t> sorted = sorted_by(loop, given);
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
  constexpr uint64_t kPasses = 4, kAtATime = 1u << 15;  // over all keys, which each counts and then moves
  EXPECT_GE(asked, 2 * kPasses * given.size() / kAtATime);
}

}  // namespace
}  // namespace collided::test
