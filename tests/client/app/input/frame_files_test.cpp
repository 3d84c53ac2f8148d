// The order of frames in files.

#include "client/app/input/frame_files.hpp"

#include <gtest/gtest.h>

namespace collided::cli {
namespace {

using Names = std::vector<std::string>;

Names sorted(Names names) {
  sort_naturally(names);
  return names;
}

TEST(FrameFiles, NumbersCountByTheirValue) {
  EXPECT_EQ(sorted({"f10", "f9", "f2"}), (Names{"f2", "f9", "f10"}));
  EXPECT_EQ(sorted({"10", "9a", "9"}), (Names{"9", "9a", "10"}));
  EXPECT_EQ(sorted({"b1", "a2", "a10b2", "a10b1"}), (Names{"a2", "a10b1", "a10b2", "b1"}));
}

TEST(FrameFiles, NumbersMayHaveZerosInFrontAndAnyLength) {
  EXPECT_EQ(sorted({"f010", "f9", "f0011"}), (Names{"f9", "f010", "f0011"}));
  EXPECT_EQ(sorted({"f1", "f01", "f0"}), (Names{"f0", "f01", "f1"}));
  const std::string nines(40, '9');
  EXPECT_EQ(sorted({"f1" + std::string(40, '0'), "f" + nines}), (Names{"f" + nines, "f1" + std::string(40, '0')}));
}

TEST(FrameFiles, NamesOfBytesAreSorted) {
  EXPECT_EQ(sorted({"", "a", "\xff"}), (Names{"", "a", "\xff"}));
  EXPECT_EQ(sorted({}), Names{});
}

}  // namespace
}  // namespace collided::cli
