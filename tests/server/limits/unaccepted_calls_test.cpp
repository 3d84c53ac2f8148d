// Calls that have arrived and wait to be accepted.
#include "server/limits/unaccepted_calls.hpp"

#include <gtest/gtest.h>

namespace collided::server {
namespace {

TEST(UnacceptedCalls, AConnectionMayHaveSoMany) {
  UnacceptedCalls calls(2, 100);
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
  UnacceptedCalls calls(1, 100);
  const int one = 0;
  EXPECT_TRUE(calls.arrive(&one));
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(calls.arrive(&one));
  EXPECT_EQ(calls.waiting(), 1u);
  calls.accept(&one);
  EXPECT_EQ(calls.waiting(), 0u);
}

TEST(UnacceptedCalls, WhereTooManyWaitInAllEachConnectionMayHaveOne) {
  UnacceptedCalls calls(8, 10);
  const int connections[20] = {};
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(calls.arrive(&connections[0]));
  EXPECT_TRUE(calls.arrive(&connections[1]));
  EXPECT_FALSE(calls.is_full());
  EXPECT_TRUE(calls.arrive(&connections[1]));
  EXPECT_TRUE(calls.is_full());
  EXPECT_FALSE(calls.arrive(&connections[1]));
  for (int i = 2; i < 20; ++i) {
    EXPECT_TRUE(calls.arrive(&connections[i])) << i;
    EXPECT_FALSE(calls.arrive(&connections[i])) << i;
  }
  EXPECT_EQ(calls.waiting(), 28u);
  for (int i = 2; i < 20; ++i) calls.accept(&connections[i]);
  calls.accept(&connections[0]);
  EXPECT_FALSE(calls.is_full());
  EXPECT_TRUE(calls.arrive(&connections[1]));
}

}  // namespace
}  // namespace collided::server
