// Shortened texts stay UTF-8.
#include "server/shorten.hpp"

#include <gtest/gtest.h>

namespace collided::server {
namespace {

TEST(Shorten, CutsBetweenCharacters) {
  EXPECT_EQ(shorten("abc", 3), "abc");
  EXPECT_EQ(shorten("abcd", 3), "abc");
  EXPECT_EQ(shorten("a\u00e9\u00e9", 4), "a\u00e9");
  EXPECT_EQ(shorten("a\u00e9\u00e9", 3), "a\u00e9");
  EXPECT_EQ(shorten("\u20ac", 2), "");
}

}  // namespace
}  // namespace collided::server
