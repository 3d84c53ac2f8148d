// Suggestions for mistyped words.

#include "client/app/options/usage.hpp"

#include <gtest/gtest.h>

namespace collided::cli {
namespace {

TEST(EditDistance, CountsLetters) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("stream", "steam"), 1u);
  EXPECT_EQ(edit_distance("scene", "scnee"), 2u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

TEST(Nearest, IsNamedIfItIsNearEnough) {
  const std::vector<std::string> known{"detect", "stream", "scenes", "info"};
  EXPECT_EQ(nearest("steam", known), "stream");
  EXPECT_EQ(nearest("detects", known), "detect");
  EXPECT_EQ(nearest("frobnicate", known), "");
  EXPECT_EQ(nearest("x", {}), "");
  EXPECT_EQ(nearest("x", {"f32", "ab"}), "");
}

TEST(Nearest, IsFoundByTheLettersNotTheDashes) {
  const std::vector<std::string> known{"--report", "--threads", "--thickness", "--t0"};
  EXPECT_EQ(nearest("--treads", known), "--threads");
  EXPECT_EQ(nearest("-thicknes", known), "--thickness");
  EXPECT_EQ(nearest("--treshold", known), "");
  EXPECT_EQ(nearest("--x", known), "");
}

TEST(Controls, AreWrittenAsNumbers) {
  EXPECT_EQ(without_controls("a\x1b[31m\n\x7f\x01"), "a\\x1b[31m\\x0a\\x7f\\x01");
  EXPECT_EQ(without_controls("Gr\u00fc\u00dfe"), "Gr\u00fc\u00dfe");
}

}  // namespace
}  // namespace collided::cli
