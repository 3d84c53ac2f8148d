// Shares of a scene's pairs: blocks of space are dealt out without gaps or doubles, and shares follow given times.

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <thread>

#include "gpu/scene/shards/balance.hpp"
#include "gpu/scene/shards/meeting.hpp"

namespace collided {
namespace {

constexpr Box<float> kBounds{{-3, 0, 1}, {13, 5, 9}};

/// The shares of so many parts, in blocks of one level.
std::vector<Share> shares(const ShareBalance& balance, int level) {
  std::vector<Share> all;
  for (size_t k = 0; k < balance.shards(); ++k) all.push_back({balance.range(k), grid_over(kBounds, 0, 0), level});
  return all;
}
/// Up to `largest` a side.
Box<float> random_box(std::mt19937& random, float largest) {
  std::uniform_real_distribution<float> part(0, 1);
  Box<float> box;
  const Vec3<float> extent = kBounds.hi - kBounds.lo;
  const float size = largest * part(random);
  box.lo = {kBounds.lo.x + part(random) * extent.x, kBounds.lo.y + part(random) * extent.y,
            kBounds.lo.z + part(random) * extent.z};
  box.hi = {min(box.lo.x + size * part(random), kBounds.hi.x), min(box.lo.y + size * part(random), kBounds.hi.y),
            min(box.lo.z + size * part(random), kBounds.hi.z)};
  return box;
}

TEST(Share, EachPairIsOnePartsAndTouchesItsBlocks) {
  std::mt19937 random(5);
  uint64_t pairs = 0;
  for (const size_t parts : {1u, 2u, 3u, 5u, 64u})
    for (const int level : {0, 1, 3, 6, 16}) {
      const std::vector<Share> all = shares(ShareBalance(parts), level);
      for (int i = 0; i < 2000; ++i) {
        const Box<float> boxes[] = {random_box(random, 6), random_box(random, i % 2 == 0 ? 6 : 1)};
        if (!overlap(boxes[0], boxes[1])) continue;
        ++pairs;
        size_t owners = 0;
        for (const Share& share : all)
          if (SharedPairs{&share, boxes}.has(0, 1)) {
            ++owners;
            EXPECT_TRUE(share.touches(boxes[0]) && share.touches(boxes[1]));
          }
        ASSERT_EQ(owners, 1u);
      }
    }
  EXPECT_GT(pairs, 1000u);
}

TEST(Share, CellsWithinABlockAreOfThePartsThatTheirPointsAre) {
  std::mt19937 random(7);
  const LevelGrid lattice = grid_over(kBounds, 2, 5);
  LevelGrid other = lattice;
  other.cells_per_length *= 1.5f;
  for (const int level : {0, 3, 6, 16}) {
    const std::vector<Share> all = shares(ShareBalance(3), level);
    for (int cell_level = 0; cell_level <= kDeepest; ++cell_level) {
      ASSERT_EQ(all[0].holds_cells(lattice, cell_level), cell_level >= level);
      ASSERT_FALSE(all[0].holds_cells(other, cell_level));
      if (cell_level < level) continue;
      for (int i = 0; i < 200; ++i) {
        const Vec3<float> point = random_box(random, 1).lo;
        const Coords cell = shifted(lattice.deepest_cell(point), kDeepest - cell_level);
        for (const Share& share : all) ASSERT_EQ(share.has_cell(cell, cell_level), share.has(point));
      }
    }
  }
}

TEST(Share, TrianglesOfOtherBlocksAreLeftOut) {
  std::mt19937 random(6);
  const std::vector<Share> all = shares(ShareBalance(8), 6);
  size_t kept[8] = {};
  constexpr int kBoxes = 40000;
  for (int i = 0; i < kBoxes; ++i) {
    Box<float> box = random_box(random, 1);
    box.hi = {min(box.lo.x + 0.01f, kBounds.hi.x), min(box.lo.y + 0.01f, kBounds.hi.y),
              min(box.lo.z + 0.01f, kBounds.hi.z)};
    for (size_t k = 0; k < all.size(); ++k) kept[k] += all[k].touches(box);
  }
  for (const size_t count : kept) {
    EXPECT_GT(count, kBoxes / 8 * 9 / 10);
    EXPECT_LT(count, kBoxes / 8 * 13 / 10);
  }
}

TEST(Share, BlocksAreManyTrianglesWide) {
  const uint64_t all = ShareRange::kAll;
  EXPECT_EQ(block_level(all), 0);       // one triangle as large as the scene
  EXPECT_EQ(block_level(all / 8), 3);   // few: a block for each
  EXPECT_EQ(block_level(all / 64), 4);  // 16 blocks a side, each 4 triangles wide
  EXPECT_EQ(block_level(all / 2048), 6);
  EXPECT_EQ(block_level(0), 16);
}

/// What parts of such speeds take, of work that is even over all shares, and `fixed` besides.
std::vector<double> times(const ShareBalance& balance, const std::vector<double>& speeds, double fixed) {
  std::vector<double> all;
  for (size_t k = 0; k < speeds.size(); ++k) all.push_back(fixed + 100 * balance.size(k) / speeds[k]);
  return all;
}
double imbalance(const std::vector<double>& times) {
  const double mean = std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
  return *std::max_element(times.begin(), times.end()) / mean - 1;
}

TEST(ShareBalance, BeginsWithEqualShares) {
  const ShareBalance balance(5);
  for (size_t k = 0; k < 5; ++k) EXPECT_NEAR(balance.size(k), 0.2, 1e-12);
  EXPECT_EQ(balance.range(0).begin, 0u);
  EXPECT_EQ(balance.range(4).end, ShareRange::kAll);
  for (size_t k = 0; k + 1 < 5; ++k) EXPECT_EQ(balance.range(k).end, balance.range(k + 1).begin);
}

TEST(ShareBalance, FollowsTheTimes) {
  for (const double fixed : {0.0, 5.0, 40.0}) {
    ShareBalance balance(4);
    const std::vector<double> speeds = {1, 2, 0.5, 1.5};
    for (int frame = 0; frame < 120; ++frame) balance.observe(times(balance, speeds, fixed));
    EXPECT_LE(imbalance(times(balance, speeds, fixed)), ShareBalance::kEven + 1e-9) << fixed;
    double sum = 0;
    for (size_t k = 0; k < 4; ++k) sum += balance.size(k);
    EXPECT_NEAR(sum, 1, 1e-12);
    for (size_t k = 0; k + 1 < 4; ++k) EXPECT_EQ(balance.range(k).end, balance.range(k + 1).begin);
  }
}

TEST(ShareBalance, KeepsToSharesThatAreEvenEnough) {
  ShareBalance balance(2);
  for (int frame = 0; frame < 50; ++frame) balance.observe(std::vector{10.0, 10.2});
  EXPECT_EQ(balance.size(0), 0.5);
}

TEST(ShareBalance, TakesNoNoticeOfOneSlowFrame) {
  ShareBalance balance(2);
  for (int frame = 0; frame < 50; ++frame) balance.observe(std::vector{10.0, frame % 5 == 3 ? 90.0 : 10.0});
  EXPECT_EQ(balance.size(0), 0.5);
}

// However long a part takes, and whatever its share is: it keeps a share, and so a chance to be faster.
TEST(ShareBalance, LeavesEachPartAShare) {
  ShareBalance balance(3);
  for (int frame = 0; frame < 300; ++frame) balance.observe(std::vector{1.0, 1000.0, 1.0});
  for (size_t k = 0; k < 3; ++k) EXPECT_GE(balance.size(k), ShareBalance::kLeast / 3 - 1e-12);
  for (int frame = 0; frame < 30; ++frame) balance.observe(std::vector{0.0, 0.0, 0.0});
  for (int frame = 0; frame < 300; ++frame) balance.observe(times(balance, {1, 1, 1}, 1));
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(balance.size(k), 1.0 / 3, 0.03);
}

TEST(Meeting, TellsAllWhatAllFound) {
  Meeting meeting(3);
  meeting.begin();
  std::vector<Found> found(3);
  std::vector<std::thread> threads;
  for (size_t k = 0; k < 3; ++k)
    threads.emplace_back([&, k] {
      Asks asks;
      for (int round = 0; round < 200; ++round)
        found[k] = meeting.meet({k == 1, 0.5 + 0.1 * static_cast<double>((k + 2) % 3)}, asks);
    });
  for (std::thread& thread : threads) thread.join();
  for (const Found& one : found) {
    EXPECT_TRUE(one.any_contact);
    EXPECT_EQ(one.earliest_toi, 0.5);
  }
}

TEST(Meeting, FailsInAllIfOneFails) {
  for (int run = 0; run < 50; ++run) {
    Meeting meeting(2);
    meeting.begin();
    bool has_failed = false;
    std::thread other([&] {
      Asks asks;
      try {
        meeting.meet({}, asks);
      } catch (const ShardFailed&) {
        has_failed = true;
      }
    });
    try {
      throw ResourceExhausted("no room");
    } catch (...) {
      meeting.fail();
    }
    other.join();
    EXPECT_TRUE(has_failed);
    EXPECT_THROW(std::rethrow_exception(meeting.error()), ResourceExhausted);
  }
}

// Who waits asks whether the frame goes on, and no one is left waiting if not.
TEST(Meeting, IsGivenUpWhileAPartWaits) {
  Meeting meeting(2);
  meeting.begin();
  Asks asks;
  asks.begin([] { return true; });
  EXPECT_THROW(meeting.meet({}, asks), Cancelled);
  Asks others;
  EXPECT_THROW(meeting.meet({}, others), ShardFailed);
}

}  // namespace
}  // namespace collided
