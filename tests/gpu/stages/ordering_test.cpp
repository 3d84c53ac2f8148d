// Canonical order against the standard library's sort.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "gpu/contacts/order.hpp"
#include "gpu/exec/cpu/cpu_exec.hpp"

namespace collided::test {
namespace {

struct Shape {
  const char* name;
  uint64_t entries, first_ids;
  double crowding;  ///< share of the entries that have the same first id
};

class Ordering : public testing::TestWithParam<Shape> {};

TEST_P(Ordering, EqualsAPlainSort) {
  const Shape shape = GetParam();
  CpuExec exec(2, 0);
  std::mt19937_64 random(shape.entries);
  std::vector<uint64_t> keys(shape.entries);
  for (uint64_t i = 0; i < keys.size(); ++i) {
    const bool crowded = static_cast<double>(random() % 1000) < 1000 * shape.crowding;
    const uint64_t first = crowded ? shape.first_ids / 2 : random() % shape.first_ids;
    keys[i] = first << 32 | (i * 2654435761u & 0xffffffffu);  // second ids differ
  }
  std::vector<uint64_t> data = keys, expected = keys;
  std::sort(expected.begin(), expected.end());

  OrderBuffers<CpuExec> buffers(exec);
  buffers.reserve(shape.first_ids, keys.size() + 10);
  std::vector<uint64_t> sorted(keys.size() + 10, 0);
  const uint64_t count = keys.size();
  uint64_t crowded = 0;
  put_in_order_by_counts(exec, buffers, {&count, count}, Span<const uint64_t>{keys.data(), count},
                         Span<const uint64_t>{data.data(), count}, Span<uint64_t>{sorted.data(), sorted.size()},
                         &crowded);
  for (uint64_t i = 0; i < count; ++i) {
    ASSERT_EQ(buffers.sorted_keys.data()[i], expected[i]) << i;
    ASSERT_EQ(sorted[i], expected[i]) << "data went elsewhere, " << i;
  }
  EXPECT_EQ(crowded > 0, shape.crowding > 0);
}

TEST(RankFew, EqualsAPlainSort) {
  std::mt19937_64 random(7);
  CpuExec exec(1, 0);
  for (const uint64_t count : {uint64_t{0}, uint64_t{1}, uint64_t{2}, uint64_t{33}, kFewContacts}) {
    std::vector<uint64_t> keys(count), sorted_keys(count), sorted(count);
    for (uint64_t i = 0; i < count; ++i) keys[i] = random() % 16 << 32 | i;
    std::shuffle(keys.begin(), keys.end(), random);
    std::vector<uint64_t> expected = keys;
    std::sort(expected.begin(), expected.end());
    const Span<const uint64_t> given{keys.data(), count};
    exec.for_each_group(
        "rank_few", {&count, count},
        RankFew<uint64_t>{{&count, count}, given, given, {sorted_keys.data(), count}, {sorted.data(), count}});
    EXPECT_EQ(sorted_keys, expected);
    EXPECT_EQ(sorted, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Ordering,
                         testing::Values(Shape{"none", 0, 10, 0}, Shape{"one", 1, 1, 0},
                                         Shape{"sparse", 5000, 20000, 0}, Shape{"dense", 20000, 500, 0},
                                         Shape{"crowded", 5000, 100, 0.5}, Shape{"all_the_same", 3001, 1, 1}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace collided::test
