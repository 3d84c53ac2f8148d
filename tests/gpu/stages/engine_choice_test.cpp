// Which engine a scene uses that leaves the choice open.

#include "gpu/step/engine_choice.hpp"

#include <gtest/gtest.h>

namespace collided::test {
namespace {

FrameCounts counts(uint64_t tests, uint64_t pairs, uint64_t registrations) {
  FrameCounts c;
  c.tests = tests, c.pairs = pairs, c.registrations = registrations;
  return c;
}

TEST(EngineChoice, IsWhatWasAskedFor) {
  EngineChoice choice(Engine::kUniformGrid);
  choice.observe(counts(1u << 30, 0, 1u << 30), 10, false);
  EXPECT_EQ(choice.engine(), Engine::kUniformGrid);
}

TEST(EngineChoice, StaysWithTheOctreeAsLongAsItsTestsAreForSomething) {
  EngineChoice choice(Engine::kAuto);
  EXPECT_EQ(choice.engine(), Engine::kOctree);
  choice.observe(counts(80'000, 15'000, 4000), 1000, false);  // a cloth
  EXPECT_EQ(choice.engine(), Engine::kOctree);
  choice.observe(counts(600'000, 500'000, 1000), 1000, false);  // all in one place: every test finds a pair
  EXPECT_EQ(choice.engine(), Engine::kOctree);
}

TEST(EngineChoice, TriesTheOctreeAgainAfterSomeFramesOfTheHierarchy) {
  EngineChoice choice(Engine::kAuto);
  choice.observe(counts(2'000'000, 20'000, 2000), 1000, false);  // tests in vain
  for (int frame = 0; frame < 256; ++frame) {
    ASSERT_EQ(choice.engine(), Engine::kLbvh);
    choice.observe(counts(70'000, 20'000, 0), 1000, false);
  }
  EXPECT_EQ(choice.engine(), Engine::kOctree);
  choice.observe(counts(20'000, 20'000, 24'001), 1000, false);  // too many registrations
  EXPECT_EQ(choice.engine(), Engine::kLbvh);
}

TEST(EngineChoice, LeavesScenesOfMixedScaleToTheHierarchy) {
  EngineChoice choice(Engine::kAuto);
  choice.observe(counts(30'000, 20'000, 4000), 1000, true);
  EXPECT_EQ(choice.engine(), Engine::kLbvh);
}

}  // namespace
}  // namespace collided::test
