// The search for the highest rate, on given results.

#include "client/measure/load/search.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace collided::cli::load {
namespace {

/// Searches a daemon that holds every rate up to `capacity`. Returns the rates that were tried.
std::vector<double> search(RateSearch& search, double capacity) {
  std::vector<double> tried;
  while (const auto rate = search.next()) {
    tried.push_back(*rate);
    search.report(*rate <= capacity);
    if (tried.size() > 100) break;
  }
  return tried;
}

TEST(LoadSearch, DoublesThenHalvesTheGapDownToThePrecision) {
  RateSearch at(10, 0.05);
  const std::vector<double> tried = search(at, 300);
  EXPECT_EQ(std::vector<double>(tried.begin(), tried.begin() + 7), (std::vector<double>{10, 20, 40, 80, 160, 320, 320}));
  EXPECT_LE(tried.size(), 7U + 2 * 4);  // the gap of a factor of 2 is halved four times
  ASSERT_TRUE(at.best());
  EXPECT_LE(*at.best(), 300);
  EXPECT_GE(*at.best() * 1.05, 300);
}

TEST(LoadSearch, ComesDownFromARateThatIsTooHigh) {
  RateSearch at(1000, 0.1);
  const std::vector<double> tried = search(at, 30);
  EXPECT_EQ(tried[1], 1000);
  EXPECT_EQ(tried[2], 500);
  ASSERT_TRUE(at.best());
  EXPECT_LE(*at.best(), 30);
  EXPECT_GE(*at.best() * 1.1, 30);
}

TEST(LoadSearch, EndsWhereNothingHoldsAndWhereEverythingDoes) {
  RateSearch none(100, 0.05), all(100, 0.05);
  EXPECT_LT(search(none, 0).size(), 40U);
  EXPECT_FALSE(none.best());
  EXPECT_LT(search(all, 1e9).size(), 20U);
  EXPECT_EQ(all.best(), RateSearch::kMaxRate);
}

TEST(LoadSearch, OneBadTrialIsNotBelieved) {
  RateSearch at(100, 0.05);
  for (const bool held : {false, true, false, true}) at.report(held);
  EXPECT_EQ(at.best(), 200);
  EXPECT_EQ(at.next(), 400);
}

TEST(LoadSearch, ARateThatFailedTwiceIsNotTriedAgain) {
  RateSearch at(100, 0.05);
  for (const bool held : {true, false, false, true, false, false}) {
    ASSERT_TRUE(at.next());
    at.report(held);
  }
  ASSERT_TRUE(at.next());
  EXPECT_GT(*at.next(), *at.best());
  EXPECT_LT(*at.next(), 200);
}

}  // namespace
}  // namespace collided::cli::load
