// Axes of plots: where values go, a row for zero, ticks. The pictures are drawn and looked at in cli/tradeoff_test.py.

#include "client/cli/plot.hpp"

#include <gtest/gtest.h>

namespace collided::cli {
namespace {

TEST(LogAxis, KeepsOrderAndRoomAtBothEnds) {
  const LogAxis axis({3, 40, 0.2}, 100, 500);
  EXPECT_GT(axis.place(0.2), 100);
  EXPECT_LT(axis.place(0.2), axis.place(3));
  EXPECT_LT(axis.place(3), axis.place(40));
  EXPECT_LT(axis.place(40), 500);
  EXPECT_EQ(axis.place(0), 100);  // no row for zero: at the low end
}

TEST(LogAxis, HasARowForZeroBelowEveryValue) {
  const LogAxis axis({0, 1, 1000}, 500, 100, LogAxis::Zero::kRow);  // upward
  EXPECT_GT(axis.place(0), axis.zero_end());
  EXPECT_LT(axis.place(1), axis.zero_end());
  EXPECT_LT(axis.place(1000), axis.place(1));
  EXPECT_EQ(axis.place(-1e-9), axis.place(0));
  EXPECT_EQ(axis.ticks().front().label, "0");
}

TEST(LogAxis, HasADecadeWhereThereIsNoPositiveValue) {
  for (const std::vector<double>& values : {std::vector<double>{}, {0, 0}, {-1}}) {
    const LogAxis axis(values, 0, 100, LogAxis::Zero::kRow);
    EXPECT_EQ(axis.place(1), axis.zero_end());
    EXPECT_EQ(axis.place(10), 100);
  }
}

TEST(LogAxis, TicksArePowersOfTenWhereItIsTight) {
  std::vector<std::string> labels;
  for (const Tick& tick : LogAxis({1e-6, 1e4}, 0, 400).ticks()) labels.push_back(tick.label);
  EXPECT_EQ(labels,
            (std::vector<std::string>{"10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "0.01", "0.1", "1", "10", "100", "1000", "10⁴"}));
}

TEST(LogAxis, TicksAreOneTwoFiveWhereThereIsRoom) {
  std::vector<std::string> labels;
  for (const Tick& tick : LogAxis({0.06, 0.7}, 0, 400).ticks()) labels.push_back(tick.label);
  EXPECT_EQ(labels, (std::vector<std::string>{"0.05", "0.1", "0.2", "0.5", "1"}));
}

TEST(LogAxis, FarApartValuesDoNotMakeItEndless) {
  const LogAxis axis({1e-300, 1e300}, 0, 400);
  EXPECT_LT(axis.ticks().size(), 50u);
  EXPECT_EQ(axis.place(1e-300), 0);
}

TEST(Draw, FilesThatCannotBeWrittenAreNamed) {
  try {
    draw_files("/nonexistent/a.svg", "/nonexistent/a.png", {10, 10}, [](Canvas&) {});
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("/nonexistent/a.svg: cannot be written"), std::string::npos);
  }
}

}  // namespace
}  // namespace collided::cli
