// The sockets that 'collidectl bench --end-to-end' compares with.

#include "client/measure/end_to_end/echo_peer.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace collided::cli {
namespace {

TEST(EchoPeer, TakesAndGivesAnySizes) {
  EchoPeer echo;
  for (const size_t up : {size_t{0}, size_t{1}, size_t{5'000'000}})
    for (const size_t down : {size_t{0}, size_t{3}, size_t{1'000'000}}) {
      EXPECT_GT(echo.tcp_ms({up, down}), 0);
      EXPECT_GT(echo.unix_ms({up, down}), 0);
    }
}

TEST(EchoPeer, ItsSleepDoesNotCount) {
  EchoPeer echo;
  constexpr double kHold = 200;
  const auto begin = std::chrono::steady_clock::now();
  const double ms = echo.tcp_ms({1, 1, kHold});
  const double all = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GE(all, kHold);
  EXPECT_GT(ms, 0);
  EXPECT_LE(ms, all - kHold);
}

}  // namespace
}  // namespace collided::cli
