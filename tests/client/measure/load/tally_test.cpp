// The histogram's error, and what is counted of frames.

#include "client/measure/load/tally/tally.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace collided::cli::load {
namespace {

TEST(LoadHistogram, APercentileIsNeverTooLowAndAtMostItsRelativeErrorTooHigh) {
  std::mt19937_64 random(7);
  std::vector<double> times;
  Histogram histogram;
  for (int i = 0; i < 20000; ++i) {
    times.push_back(std::pow(10, std::uniform_real_distribution(-2.9, 5.9)(random)));
    histogram.add(times.back());
  }
  std::sort(times.begin(), times.end());
  for (const double percent : {0.01, 1.0, 50.0, 90.0, 99.0, 99.9, 99.99, 100.0}) {
    const double exact = times[static_cast<size_t>(std::ceil(percent / 100 * 20000)) - 1];
    EXPECT_GE(histogram.percentile(percent), exact * (1 - 1e-12)) << percent;
    EXPECT_LE(histogram.percentile(percent), exact * (1 + Histogram::kRelativeError) * (1 + 1e-9)) << percent;
  }
}

TEST(LoadHistogram, ExtremesAndMeanAreExact) {
  Histogram histogram;
  EXPECT_EQ(histogram.percentile(99), 0);
  EXPECT_EQ(histogram.mean(), 0);
  for (const double ms : {0.0, -1.0, 1e-9, 3.0, 1e9}) histogram.add(ms);
  EXPECT_EQ(histogram.count(), 5U);
  EXPECT_EQ(histogram.min(), 0);
  EXPECT_EQ(histogram.max(), 1e9);
  EXPECT_EQ(histogram.percentile(100), 1e9);
  EXPECT_DOUBLE_EQ(histogram.mean(), (3 + 1e9 + 1e-9) / 5);
}

TEST(LoadHistogram, SumsAreThoseOfAllTimes) {
  Histogram small, large, all;
  for (int i = 1; i <= 100; ++i) {
    (i <= 50 ? small : large).add(i);
    all.add(i);
  }
  small.add(large);
  small.add(Histogram());
  EXPECT_EQ(small.count(), 100U);
  EXPECT_EQ(small.min(), 1);
  EXPECT_EQ(small.max(), 100);
  EXPECT_EQ(small.percentile(75), all.percentile(75));
}

TEST(LoadTally, RefusalsAreCountedByCodeWithTheFirstMessage) {
  Tally tally, other;
  add(tally.refused, "RESOURCE_EXHAUSTED", "first");
  add(other.refused, "RESOURCE_EXHAUSTED", "second");
  add(other.refused, "INVALID_ARGUMENT", "third");
  other.answered = 2, other.unsent = 1;
  tally += other;
  EXPECT_EQ(tally.refused.at("RESOURCE_EXHAUSTED").count, 2U);
  EXPECT_EQ(tally.refused.at("RESOURCE_EXHAUSTED").first, "first");
  EXPECT_EQ(tally.refused_count(), 3U);
  EXPECT_EQ(tally.due(), 6U);
}

}  // namespace
}  // namespace collided::cli::load
