// A lease runs from the end of the scene's last use.
#include "server/scenes/scene/lease.hpp"

#include <gtest/gtest.h>

#include "tests/server/hand_clock.hpp"

namespace collided::server {
namespace {

using std::chrono::seconds;

TEST(SceneLease, RunsFromTheEndOfTheLastUse) {
  const HandClock clock;
  const Now now = clock.now();
  SceneLease lease(10, now);
  clock.move(seconds(10));
  EXPECT_FALSE(lease.is_expired(now()));
  clock.move(seconds(1));
  EXPECT_TRUE(lease.is_expired(now()));
  lease.begin_use();
  lease.begin_use();
  EXPECT_FALSE(lease.is_expired(now()));
  lease.end_use();
  clock.move(seconds(100));
  EXPECT_FALSE(lease.is_expired(now())) << "one of two uses has ended";
  lease.end_use();
  EXPECT_FALSE(lease.is_expired(now()));
  clock.move(seconds(11));
  EXPECT_TRUE(lease.is_expired(now()));
}

}  // namespace
}  // namespace collided::server
