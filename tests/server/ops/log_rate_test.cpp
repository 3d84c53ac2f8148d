// Rate limits for lines that callers cause.
#include "server/ops/log_rate.hpp"

#include <gtest/gtest.h>

namespace collided::server {
namespace {

using std::chrono::milliseconds;

TEST(LogRate, TheFirstOfASecondAreLoggedAndTheRestCounted) {
  LogRate rate(2);
  const LogRate::Clock::time_point start{};
  EXPECT_EQ(rate.admit("a", start), 0u);
  EXPECT_EQ(rate.admit("a", start + milliseconds(1)), 0u);
  for (int i = 2; i < 100; ++i) EXPECT_FALSE(rate.admit("a", start + milliseconds(i)));
  EXPECT_EQ(rate.admit("b", start + milliseconds(100)), 0u);  // another kind
  EXPECT_EQ(rate.admit("a", start + milliseconds(1000)), 98u);
  EXPECT_EQ(rate.admit("a", start + milliseconds(1001)), 0u);
  EXPECT_FALSE(rate.admit("a", start + milliseconds(1002)));
}

}  // namespace
}  // namespace collided::server
