// The states of the daemon.
#include "server/ops/lifecycle.hpp"

#include <gtest/gtest.h>

namespace collided::server {
namespace {

TEST(Lifecycle, StartsServesAndDrains) {
  Lifecycle lifecycle;
  EXPECT_FALSE(lifecycle.serving());
  EXPECT_EQ(lifecycle.status().text(), "starting");
  lifecycle.serve();
  EXPECT_TRUE(lifecycle.serving());
  EXPECT_EQ(lifecycle.status().text(), "ready");
  lifecycle.drain();
  EXPECT_FALSE(lifecycle.serving());
  EXPECT_EQ(lifecycle.status().text(), "draining");
  lifecycle.serve();
  EXPECT_FALSE(lifecycle.serving());
}

TEST(Lifecycle, AFailureIsFinalAndWakesOnce) {
  int woken = 0;
  Lifecycle lifecycle([&] { ++woken; });
  lifecycle.serve();
  lifecycle.fail("device 0 is lost");
  lifecycle.fail("later");
  lifecycle.drain();
  lifecycle.serve();
  EXPECT_TRUE(lifecycle.failed());
  EXPECT_EQ(lifecycle.status().text(), "failed: device 0 is lost");
  EXPECT_EQ(woken, 1);
}

}  // namespace
}  // namespace collided::server
