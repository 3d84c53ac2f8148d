// When frames are due: rates, ramps, fixed and random arrivals.

#include "client/measure/load/pace/schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "client/app/options/usage_error.hpp"

namespace collided::cli::load {
namespace {

std::vector<double> times_of(const RateProfile& profile, Arrivals arrivals, StreamPlace place = {}, uint64_t seed = 1) {
  Schedule schedule(profile, arrivals, place, seed);
  std::vector<double> times;
  for (double time = schedule.next(); std::isfinite(time); time = schedule.next()) times.push_back(time);
  return times;
}

TEST(LoadSchedule, FixedFramesAreEvenlySpacedAndStreamsSpreadBetweenThem) {
  const RateProfile profile(4, 1);
  EXPECT_EQ(times_of(profile, Arrivals::kFixed), (std::vector<double>{0, 0.25, 0.5, 0.75}));
  EXPECT_EQ(times_of(profile, Arrivals::kFixed, {1, 2}), (std::vector<double>{0.125, 0.375, 0.625, 0.875}));
}

TEST(LoadSchedule, ARampBringsTheFramesThatItsRateAddsUpTo) {
  const RateProfile profile({{0, 10, 2}, {10, 10, 1}, {10, 0, 2}});
  EXPECT_EQ(profile.seconds(), 5);
  EXPECT_EQ(profile.frames(), 30);
  EXPECT_EQ(profile.max_rate(), 10);
  EXPECT_NEAR(profile.time_of(2.5), 1, 1e-12);
  EXPECT_NEAR(profile.time_of(10), 2, 1e-12);
  EXPECT_NEAR(profile.time_of(15), 2.5, 1e-12);
  EXPECT_NEAR(profile.time_of(27.5), 4, 1e-9);
  EXPECT_TRUE(std::isinf(profile.time_of(30)));
  const std::vector<double> times = times_of(profile, Arrivals::kFixed);
  EXPECT_EQ(times.size(), 30U);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST(LoadSchedule, PoissonArrivalsAreThoseOfTheirSeedAndStream) {
  const RateProfile profile(1000, 100);
  const std::vector<double> times = times_of(profile, Arrivals::kPoisson, {3, 8}, 42);
  EXPECT_EQ(times, times_of(profile, Arrivals::kPoisson, {3, 8}, 42));
  EXPECT_NE(times, times_of(profile, Arrivals::kPoisson, {4, 8}, 42));
  EXPECT_NE(times, times_of(profile, Arrivals::kPoisson, {3, 8}, 43));
  // 100,000 frames, with a deviation of 316; gaps of an exponential distribution, of which 1/e exceed the mean
  EXPECT_NEAR(static_cast<double>(times.size()), 1e5, 5 * 316);
  double long_gaps = 0;
  for (size_t i = 1; i < times.size(); ++i) long_gaps += times[i] - times[i - 1] > 1e-3;
  EXPECT_NEAR(long_gaps / static_cast<double>(times.size()), std::exp(-1), 0.01);
}

TEST(LoadSchedule, RampsAreReadFromText) {
  const std::vector<Stretch> stretches = parse_ramp("--ramp", "10:60.5:30,60.5:60.5:5");
  ASSERT_EQ(stretches.size(), 2U);
  EXPECT_EQ(stretches[0].from, 10);
  EXPECT_EQ(stretches[0].to, 60.5);
  EXPECT_EQ(stretches[1].seconds, 5);
  for (const char* bad : {"", "10", "10:20", "10:20:0", "-1:2:3", "1:2:3:4", "a:b:c", "nan:1:1", "1:inf:1", "0:0:5"})
    EXPECT_THROW(parse_ramp("--ramp", bad), UsageError) << bad;
}

}  // namespace
}  // namespace collided::cli::load
