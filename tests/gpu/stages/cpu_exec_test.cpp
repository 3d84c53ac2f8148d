// The verbs of the CPU backend against plain loops, with one thread and with two.

#include "gpu/exec/cpu_exec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "gpu/exec/buffer.hpp"

namespace collided::test {
namespace {

class CpuExecTest : public testing::TestWithParam<int> {
 protected:
  CpuExec exec{GetParam(), 0};
};

struct CountVisits {
  Span<uint32_t> visits;
  Span<const uint64_t> offsets;
  void operator()(uint64_t item, uint64_t rank) const { atomic_add(visits[offsets[item] + rank], 1u); }
};

TEST_P(CpuExecTest, ExpandedVisitsEveryUnitOfEveryItemOnce) {
  std::mt19937 random(5);
  std::vector<uint64_t> offsets(1001);
  for (size_t i = 0; i < 1000; ++i) offsets[i] = random() % 3 == 0 ? 0 : random() % 50;
  exec.exclusive_scan("scan", Span<uint64_t>{offsets.data(), offsets.size()});
  std::vector<uint32_t> visits(offsets.back(), 0);
  const Span<const uint64_t> view{offsets.data(), offsets.size()};
  exec.for_each_expanded("visit", view, offsets.back(), CountVisits{{visits.data(), visits.size()}, view});
  EXPECT_TRUE(std::all_of(visits.begin(), visits.end(), [](uint32_t n) { return n == 1; }));
}

TEST_P(CpuExecTest, SortKeepsKeysAndOrderTogether) {
  std::mt19937_64 random(6);
  std::vector<uint64_t> keys(5000), before;
  for (uint64_t& key : keys) key = random();
  before = keys;
  std::vector<uint32_t> order(keys.size());
  exec.sort_with_order("sort", {keys.data(), keys.size()}, {order.data(), order.size()});
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
  for (size_t i = 0; i < keys.size(); ++i) ASSERT_EQ(before[order[i]], keys[i]);
}

TEST_P(CpuExecTest, CancellationStopsBeforeTheStage) {
  bool ran = false;
  exec.cancelled = [] { return true; };
  EXPECT_THROW(exec.stage("stage", [&] { ran = true; }), Cancelled);
  EXPECT_FALSE(ran);
}

INSTANTIATE_TEST_SUITE_P(Threads, CpuExecTest, testing::Values(1, 2));

TEST(MemoryLedger, RefusesPastTheBudgetAndNamesNeedAndBudget) {
  CpuExec exec(1, 1000);
  Buffer<uint64_t, CpuExec> buffer(exec, "pairs");
  buffer.allocate(100);
  try {
    Buffer<uint64_t, CpuExec> second(exec, "boxes");
    second.allocate(100);
    FAIL() << "no exception";
  } catch (const ResourceExhausted& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("boxes"), std::string::npos);
    EXPECT_NE(text.find("1000"), std::string::npos);
    EXPECT_NE(text.find("800"), std::string::npos);
  }
  EXPECT_EQ(exec.ledger().parts().size(), 1u);
}

}  // namespace
}  // namespace collided::test
