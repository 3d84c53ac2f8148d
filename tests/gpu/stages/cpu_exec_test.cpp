// The verbs of the CPU backend against plain loops, with one thread and with two.

#include "gpu/exec/cpu/cpu_exec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <ctime>
#include <thread>
#include <vector>

#include "gpu/exec/buffer.hpp"
#include "gpu/search/cpu/list_writer.hpp"

namespace collided::test {
namespace {

class CpuExecTest : public testing::TestWithParam<int> {
 protected:
  CpuExec exec{GetParam(), 0};
};

struct CountVisits {
  Span<uint32_t> visits;
  void operator()(uint64_t i) const { atomic_add(visits[i], 1u); }
};

TEST_P(CpuExecTest, CountedLengthIsReadWhenTheStageRunsAndCutOffAtTheCapacity) {
  std::vector<uint32_t> visits(1000, 0);
  uint64_t counter = 700;
  const Counted counted{&counter, visits.size()};
  exec.for_each("visit", counted, CountVisits{{visits.data(), visits.size()}});
  counter = 5000;
  exec.for_each("visit", counted, CountVisits{{visits.data(), visits.size()}});
  for (size_t i = 0; i < visits.size(); ++i) ASSERT_EQ(visits[i], i < 700 ? 2u : 1u);
}

struct SumInGroup {
  struct Shared {
    uint64_t sum;
  };
  static constexpr uint32_t kGroupSize = 64;
  Span<uint64_t> out;
  void operator()(uint64_t i, const Group& group, Shared& shared) const {
    if (group.rank == 0) shared.sum = 0;
    group.sync();
    for (uint64_t k = group.rank; k < 100; k += group.size) atomic_add(shared.sum, i * k);
    group.sync();
    if (group.rank == 0) out[i] = shared.sum;
  }
};

struct VisitSlowly {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 1;
  Span<uint32_t> visits;
  void operator()(uint64_t i, const Group&, Nothing&) const {
    volatile uint64_t sum = 0;
    for (uint64_t k = 0; k < 1000; ++k) sum = sum + k;
    atomic_add(visits[i], 1u);
  }
};

TEST_P(CpuExecTest, GroupsHaveTheirOwnSharedMemory) {
  std::vector<uint64_t> out(500);
  const uint64_t count = out.size();
  exec.for_each_group("sum", {&count, count}, SumInGroup{{out.data(), count}});
  for (uint64_t i = 0; i < count; ++i) ASSERT_EQ(out[i], i * 4950);
}

TEST_P(CpuExecTest, SortsPairsStably) {
  constexpr int kBits = 20;
  std::vector<uint64_t> keys(100'000), other_keys(keys.size());
  std::vector<uint32_t> values(keys.size()), other_values(keys.size()), expected(keys.size());
  for (uint32_t i = 0; i < keys.size(); ++i) {
    keys[i] = i * 2654435761ull % 50'000;
    values[i] = expected[i] = i;
  }
  const std::vector<uint64_t> given = keys;
  std::stable_sort(expected.begin(), expected.end(), [&](uint32_t a, uint32_t b) { return given[a] < given[b]; });
  const int sorted = exec.sort_pairs("sort", kBits,
                                     {{keys.data(), keys.size()},
                                      {other_keys.data(), keys.size()},
                                      {values.data(), keys.size()},
                                      {other_values.data(), keys.size()}});
  EXPECT_EQ(sorted == 0 ? values : other_values, expected);
  for (size_t i = 0; i < keys.size(); ++i) ASSERT_EQ((sorted == 0 ? keys : other_keys)[i], given[expected[i]]);
}

struct IdentityOf {
  uint64_t operator()(uint64_t i) const { return i; }
};
struct Larger {
  uint64_t operator()(uint64_t a, uint64_t b) const { return a < b ? b : a; }
};

TEST_P(CpuExecTest, ReduceOfNothingIsTheIdentity) {
  uint64_t result = 7;
  exec.reduce_into("largest", 0, IdentityOf{}, uint64_t{3}, Larger{}, &result);
  EXPECT_EQ(result, 3u);
  exec.reduce_into("largest", 12345, IdentityOf{}, uint64_t{3}, Larger{}, &result);
  EXPECT_EQ(result, 12344u);
}

TEST_P(CpuExecTest, StepReturnsWhatItLeft) {
  constexpr std::chrono::milliseconds kPause(2);
  uint64_t value = 0;
  const auto work = [&] {
    std::this_thread::sleep_for(kPause);
    value = 5;
  };
  EXPECT_EQ(exec.step(0, &value, work), 5u);
  EXPECT_GE(exec.step_milliseconds(), kPause.count());
}

TEST_P(CpuExecTest, CancellationStopsBeforeTheStage) {
  bool ran = false;
  exec.asks().begin([] { return true; });
  EXPECT_THROW(exec.stage("stage", [&] { ran = true; }), Cancelled);
  EXPECT_FALSE(ran);
}

// The question may take its time: others have their turn meanwhile.
TEST_P(CpuExecTest, NothingGoesOnWhileTheQuestionIsAsked) {
  std::atomic<uint64_t> begun = 0, done = 0;
  int asked = 0;
  exec.asks().begin([&] {
    const uint64_t before = begun;
    EXPECT_EQ(done, before);
    for (int k = 0; k < 100; ++k) std::this_thread::yield();
    EXPECT_EQ(begun, before);
    return ++asked == 20;
  });
  const auto work = [&](uint64_t) {
    ++begun;
    volatile uint64_t sum = 0;
    for (uint64_t k = 0; k < 1000; ++k) sum = sum + k;
    ++done;
  };
  EXPECT_THROW(exec.for_each("work", ~uint64_t{0} >> 1, work), Cancelled);
  EXPECT_EQ(asked, 20);
  EXPECT_EQ(begun, done);
}

TEST_P(CpuExecTest, WhatAQuestionInterruptsIsDoneOnce) {
  std::vector<uint32_t> visits(20'000, 0);
  exec.asks().begin([] { return false; });
  exec.for_each_group("visit", {nullptr, visits.size()}, VisitSlowly{{visits.data(), visits.size()}});
  for (const uint32_t count : visits) ASSERT_EQ(count, 1u);
}

// Items that take longer than there is between two questions: helpers leave them, the calling thread ends them.
TEST_P(CpuExecTest, ItemsThatTakeLongAreEndedAllTheSame) {
  std::array<std::atomic<int>, 5> ended{};
  int asked = 0;
  exec.asks().begin([&] { return ++asked < 0; });
  exec.host_loops().share(ended.size(), 1, [&](LoopTurn& turn) {
    try {
      while (ItemRange* items = turn.next()) {
        const std::clock_t start = std::clock();
        while (std::clock() - start < CLOCKS_PER_SEC / 50) turn.look_up();
        ++ended[items->first++];
      }
    } catch (const LeftUndone&) {
    }
  });
  for (const auto& count : ended) EXPECT_EQ(count, 1);
  EXPECT_GE(asked, 5);
}

/// An item's parts are the numbers below `parts`; each is found.
struct CountParts {
  struct Walk {
    uint32_t k;
    uint32_t next() { return k++; }
  };
  struct Item {
    uint32_t parts;
    uint32_t part(uint32_t k) const { return k; }
    Walk walk_from(uint32_t k) const { return {k}; }
  };
  uint32_t parts;
  Span<uint32_t> visits;

  Item item(uint64_t) const { return {parts}; }
  static uint32_t look(uint32_t) { return 0; }
  static uint32_t find(uint32_t part, uint32_t) { return part; }
  void act(const Item&, uint32_t part) const { atomic_add(visits[part], 1u); }
};

TEST_P(CpuExecTest, ItemsOfManyPartsAreLeftHalfDoneToLookUp) {
  std::vector<uint32_t> visits(2'000'000, 0);
  uint64_t asked = 0;
  exec.asks().begin([&] { return ++asked == 0; }, {});
  const uint64_t items = 3;
  exec.for_each_of_many_parts("count", {&items, items},
                              CountParts{static_cast<uint32_t>(visits.size()), {visits.data(), visits.size()}});
  for (const uint32_t count : visits) ASSERT_EQ(count, items);
  const uint64_t threads = static_cast<uint64_t>(GetParam());
  EXPECT_GE(asked, items * visits.size() / (1u << 17) / threads);
}

TEST_P(CpuExecTest, WritersOfAListCountPastItsCapacity) {
  std::vector<uint64_t> items(5000, ~uint64_t{0});
  for (const uint64_t each : {uint64_t{10}, uint64_t{3000}}) {
    uint64_t count = 0;
    const AppendList<uint64_t> list{{items.data(), items.size()}, &count};
    exec.for_each("write", 4, [&](uint64_t i) {
      ListWriter<uint64_t> writer(list);
      for (uint64_t k = 0; k < each; ++k) writer.push(each * i + k);
      writer.flush();
      writer.flush();
    });
    ASSERT_EQ(count, 4 * each);
    std::vector<uint64_t> written(items.begin(), items.begin() + static_cast<long>(std::min<uint64_t>(count, 5000)));
    std::sort(written.begin(), written.end());
    EXPECT_EQ(std::adjacent_find(written.begin(), written.end()), written.end()) << "each once";
    EXPECT_LT(written.back(), 4 * each);
  }
}

TEST(SharedItems, EachThreadHasAPartOfItsOwnAndThenHelpsOthers) {
  constexpr uint64_t kItems = 1003, kThreads = 4;
  SharedItems items(kItems, 10, kThreads);
  std::vector<uint32_t> visits(kItems, 0);
  const auto visit = [&](const ItemRange& range) {
    for (uint64_t i = range.first; i < range.end; ++i) ++visits[i];
  };
  uint64_t next = 0;
  ItemRange range;
  for (const uint64_t thread : {uint64_t{0}, uint64_t{2}, uint64_t{0}}) {
    ASSERT_TRUE(items.take(thread, range));
    if (thread == 2) {
      EXPECT_EQ(range.first, 502u) << "two parts of 251 before it";
    } else {
      EXPECT_EQ(range.first, next) << "goes on where it was";
      next = range.end;
    }
    visit(range);
  }
  while (items.take(3, range)) visit(range);
  EXPECT_FALSE(items.are_left());
  for (const uint32_t count : visits) ASSERT_EQ(count, 1u);
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
    EXPECT_NE(text.find("needs at least 1600 bytes"), std::string::npos);
  }
  EXPECT_EQ(exec.ledger().parts().size(), 1u);
}

TEST(AllowedWork, EndsWorkThatTakesLongerButNotWhatIsSpentInTheQuestion) {
  Asks asks;
  const auto work = [&](int milliseconds) {
    const auto end = Asks::Clock::now() + std::chrono::milliseconds(milliseconds);
    while (Asks::Clock::now() < end) continue;
    asks.ask();
  };
  asks.begin({});
  {
    const AllowedWork allowed(asks, 1);
    EXPECT_THROW(work(2), OutOfTime);
  }
  EXPECT_NO_THROW(work(2));
  EXPECT_FALSE(asks.is_due());
  {
    const AllowedWork any(asks, 0);
    EXPECT_NO_THROW(work(2));
  }
  const auto slow = [] { return std::this_thread::sleep_for(std::chrono::milliseconds(300)), false; };
  asks.begin(slow, {});
  {
    const AllowedWork allowed(asks, 200);
    EXPECT_NO_THROW(asks.ask());
    EXPECT_NO_THROW(asks.ask());
    EXPECT_THROW(work(250), OutOfTime);
  }
  {
    const AllowedWork allowed(asks, 1);
    asks.begin({});  // the next frame
    EXPECT_NO_THROW(work(2));
  }
}

}  // namespace
}  // namespace collided::test
