// Keys sorted on CPU cores against the standard library's sort.

#include "gpu/exec/key_order.hpp"

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

TEST_P(Keys, AreInAscendingOrder) {
  std::vector<uint64_t> given = keys(), expected = given, scratch(given.size()), sorted(given.size());
  std::sort(expected.begin(), expected.end());
  const KeyArrays<int> arrays{span_of(given), {}, span_of(scratch), span_of(sorted), {}};
  ASSERT_TRUE(KeyOrder(loops, arrays).run());
  EXPECT_EQ(sorted, expected);
}

TEST_P(Keys, TakeTheirDataAlong) {
  std::vector<uint64_t> given = keys(), data = given, scratch(given.size()), sorted(given.size()), along(given.size());
  for (uint64_t& d : data) d ^= 0x5555;
  const KeyArrays<uint64_t> arrays{span_of(given), span_of(data), span_of(scratch), span_of(sorted), span_of(along)};
  if (!KeyOrder(loops, arrays).run()) {
    EXPECT_GT(GetParam().first_ids, 1u << 20) << "only very many ids do not fit";
    return;
  }
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
  for (size_t i = 0; i < along.size(); ++i) ASSERT_EQ(along[i], sorted[i] ^ 0x5555) << i;
}

INSTANTIATE_TEST_SUITE_P(Shapes, Keys,
                         testing::Values(Shape{"none", 0, 1, 1}, Shape{"one", 1, 1, 1}, Shape{"few", 30, 100, 100},
                                         Shape{"all_zero", 70, 1, 1}, Shape{"many", 600'000, 276'000, 138'000},
                                         Shape{"one_first_id", 50'000, 1, 1'000'000},
                                         Shape{"one_second_id", 50'000, 1'000'000, 1},
                                         Shape{"wide", 50'000, 1u << 26, 1u << 31}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(KeyOrder, RefusesKeysWhoseBitsLeaveNoRoom) {
  std::vector<uint64_t> given{~uint64_t{0}, 3}, scratch(2), sorted(2);
  const KeyArrays<int> arrays{span_of(given), {}, span_of(scratch), span_of(sorted), {}};
  EXPECT_FALSE(KeyOrder(loops, arrays).run());
}

}  // namespace
}  // namespace collided::test
