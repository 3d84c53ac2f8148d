// Calls that have arrived and wait to be accepted.
#include "server/limits/unaccepted_calls.hpp"

#include <gtest/gtest.h>

namespace collided::server {
namespace {

TEST(UnacceptedCalls, AConnectionMayHaveSoMany) {
  UnacceptedCalls calls(2);
  const int one = 0, other = 0;
  EXPECT_TRUE(calls.arrive(&one));
  EXPECT_TRUE(calls.arrive(&one));
  EXPECT_FALSE(calls.arrive(&one));
  EXPECT_TRUE(calls.arrive(&other));
  EXPECT_EQ(calls.waiting(), 3u);
  calls.accept(&one);
  EXPECT_TRUE(calls.arrive(&one));
  EXPECT_FALSE(calls.arrive(&one));
}

TEST(UnacceptedCalls, ARefusedOneDoesNotWait) {
  UnacceptedCalls calls(1);
  const int one = 0;
  EXPECT_TRUE(calls.arrive(&one));
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(calls.arrive(&one));
  EXPECT_EQ(calls.waiting(), 1u);
  calls.accept(&one);
  EXPECT_EQ(calls.waiting(), 0u);
}

}  // namespace
}  // namespace collided::server
