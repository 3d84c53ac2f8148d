// Canonical order against the standard library's sort.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "gpu/contacts/order.hpp"
#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/step/plan/order_predictor.hpp"

namespace collided::test {
namespace {

struct Shape {
  const char* name;
  uint64_t entries, first_ids;
  double crowding;  ///< share of the entries that have the same first id
};

struct WriteKeys {
  Span<const uint64_t> data;  ///< empty: there are only keys
  Span<uint64_t> keys, along;
  bool has_data() const { return !data.empty(); }
  void operator()(uint64_t place, uint64_t key, uint64_t from) const {
    keys[place] = key;
    if (has_data()) along[place] = data[from];
  }
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
  return {{0, third, 2 * third, static_cast<uint32_t>(first_ids)}};
}

void expect_begins(const KindBegins& kinds, const std::vector<uint64_t>& sorted, const FeatureRanks& ranks) {
  const auto below = [&](uint32_t rank) {
    return static_cast<uint64_t>(std::lower_bound(sorted.begin(), sorted.end(), uint64_t{rank} << 32) - sorted.begin());
  };
  for (size_t kind = 0; kind < kContactKinds; ++kind) EXPECT_EQ(kinds.at[kind], below(ranks.begin[kind])) << kind;
}

constexpr uint64_t kSecondIds = uint64_t{1} << 32;

std::vector<uint64_t> keys_of(const Shape& shape) {
  std::mt19937_64 random(shape.entries);
  std::vector<uint64_t> keys(shape.entries);
  for (uint64_t i = 0; i < keys.size(); ++i) {
    const bool crowded = static_cast<double>(random() % 1000) < 1000 * shape.crowding;
    const uint64_t first = crowded ? shape.first_ids / 2 : random() % shape.first_ids;
    keys[i] = first << 32 | (i * 2654435761u & 0xffffffffu);  // second ids differ
  }
  return keys;
}

class Ordering : public testing::TestWithParam<Shape> {};

TEST_P(Ordering, EqualsAPlainSort) {
  const Shape shape = GetParam();
  CpuExec exec(2, 0);
  const std::vector<uint64_t> keys = keys_of(shape);
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

// What is beyond the list, up to the length of the sort, stays behind it.
TEST_P(Ordering, ByRadixEqualsAPlainSort) {
  const Shape shape = GetParam();
  CpuExec exec(2, 0);
  const std::vector<uint64_t> keys = keys_of(shape);
  std::vector<uint64_t> expected = keys;
  std::sort(expected.begin(), expected.end());
  const uint64_t count = keys.size();
  const FeatureRanks ranks = thirds_of(shape.first_ids);
  for (const uint64_t length : {count, count + 1000})
    for (const bool has_data : {true, false}) {
      RadixBuffers<CpuExec> buffers(exec);
      buffers.reserve(length, has_data);
      Written written(count);
      KindBegins kinds{};
      put_in_order_by_radix(exec, buffers,
                            Unordered<WriteKeys>{{&count, count},
                                                 {keys.data(), count},
                                                 ranks,
                                                 &kinds,
                                                 written.write(has_data ? keys : std::vector<uint64_t>{})},
                            length, KeyPacking::of(shape.first_ids, kSecondIds));
      EXPECT_EQ(written.keys, expected);
      EXPECT_EQ(written.data, has_data ? expected : std::vector<uint64_t>(count));
      expect_begins(kinds, expected, ranks);
    }
}

TEST(OrderPredictor, PlansForWhatTheLastStepsHad) {
  OrderPredictor order;
  EXPECT_EQ(order.plan().radix_length, 0u);
  EXPECT_FALSE(order.observe(500'000));
  EXPECT_EQ(order.plan().radix_length, 0u);
  EXPECT_FALSE(order.observe(3'000'000)) << "a step without a radix sort had them in order";
  const uint64_t length = order.plan().radix_length;
  EXPECT_GE(length, 3'000'000u);
  EXPECT_LE(length, 3'750'000u);
  EXPECT_FALSE(order.observe(length));
  EXPECT_TRUE(order.observe(order.plan().radix_length + 1));
  EXPECT_GT(order.plan().radix_length, length);
  for (int step = 0; step < 1000; ++step) EXPECT_FALSE(order.observe(10));
  EXPECT_EQ(order.plan().radix_length, 0u);
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
