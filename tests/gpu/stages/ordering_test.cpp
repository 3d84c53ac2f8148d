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

struct WriteKeys {
  Span<const uint64_t> data;
  Span<uint64_t> keys, along;
  void operator()(uint64_t place, uint64_t key, uint64_t from) const { keys[place] = key, along[place] = data[from]; }
};

/// What was written in order.
struct Written {
  explicit Written(uint64_t count) : keys(count), data(count) {}
  WriteKeys write(const std::vector<uint64_t>& from) {
    return {{from.data(), from.size()}, {keys.data(), keys.size()}, {data.data(), data.size()}};
  }
  std::vector<uint64_t> keys, data;
};

/// Three kinds.
FeatureRanks thirds_of(uint64_t first_ids) {
  const auto third = static_cast<uint32_t>(first_ids / 3);
  return {third, 2 * third, static_cast<uint32_t>(first_ids)};
}

void expect_begins(const KindBegins& kinds, const std::vector<uint64_t>& sorted, const FeatureRanks& ranks) {
  const auto below = [&](uint32_t rank) {
    return static_cast<uint64_t>(std::lower_bound(sorted.begin(), sorted.end(), uint64_t{rank} << 32) - sorted.begin());
  };
  EXPECT_EQ(kinds.edges, below(ranks.first_edge));
  EXPECT_EQ(kinds.triangles, below(ranks.first_triangle));
}

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

  CountingBuffers<CpuExec> buffers(exec);
  buffers.reserve(shape.first_ids, keys.size() + 10);
  Written written(keys.size() + 10);
  const uint64_t count = keys.size();
  uint64_t crowded = 0;
  KindBegins kinds{};
  const FeatureRanks ranks = thirds_of(shape.first_ids);
  put_in_order_by_counts(
      exec, buffers, Unordered<WriteKeys>{{&count, count}, {keys.data(), count}, ranks, &kinds, written.write(data)},
      &crowded);
  for (uint64_t i = 0; i < count; ++i) {
    ASSERT_EQ(written.keys[i], expected[i]) << i;
    ASSERT_EQ(written.data[i], expected[i]) << "data went elsewhere, " << i;
  }
  expect_begins(kinds, expected, ranks);
  EXPECT_EQ(crowded > 0, shape.crowding > 0);
}

TEST(RankFew, EqualsAPlainSort) {
  std::mt19937_64 random(7);
  CpuExec exec(1, 0);
  for (const uint64_t count : {uint64_t{0}, uint64_t{1}, uint64_t{2}, uint64_t{33}, kFewContacts}) {
    std::vector<uint64_t> keys(count);
    for (uint64_t i = 0; i < count; ++i) keys[i] = random() % 16 << 32 | i;
    std::shuffle(keys.begin(), keys.end(), random);
    std::vector<uint64_t> expected = keys;
    std::sort(expected.begin(), expected.end());
    const Span<const uint64_t> given{keys.data(), count};
    Written written(count);
    KindBegins kinds{};
    const FeatureRanks ranks = thirds_of(16);
    exec.for_each_group("rank_few", {&count, count},
                        RankFew<WriteKeys>{{&count, count}, given, {ranks, given}, &kinds, written.write(keys)});
    EXPECT_EQ(written.keys, expected);
    EXPECT_EQ(written.data, expected);
    expect_begins(kinds, expected, ranks);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Ordering,
                         testing::Values(Shape{"none", 0, 10, 0}, Shape{"one", 1, 1, 0},
                                         Shape{"sparse", 5000, 20000, 0}, Shape{"dense", 20000, 500, 0},
                                         Shape{"crowded", 5000, 100, 0.5}, Shape{"all_the_same", 3001, 1, 1}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace collided::test
