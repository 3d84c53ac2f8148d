// Which engine a scene uses that leaves the choice open, from times that the tests give.

#include <gtest/gtest.h>

#include <random>

#include "gpu/step/plan/engine_choices.hpp"

namespace collided::test {
namespace {

constexpr Engine kOctree = Engine::kOctree, kLbvh = Engine::kLbvh;

/// A scene, in milliseconds.
struct Costs {
  double octree = 1, lbvh = 1, others = 0.5;
  double beginning = 4;  ///< what the first frame of an engine takes besides
};

class Choice : public ::testing::Test {
 protected:
  /// A frame of the chosen engine.
  Engine run(const Costs& costs, double noise = 1) {
    const EngineFacts facts = choice_.next();
    const double search = (facts.engine == kOctree ? costs.octree : costs.lbvh) * noise;
    const bool is_new = last_ != facts.engine;
    last_ = facts.engine;
    const double total = search + costs.others + (is_new ? costs.beginning : 0);
    spent_ += total;
    trials_ += facts.reason == EngineReason::kTrial;
    choice_.observe({search, total, !is_new, facts.engine == kOctree && octree_looks_wrong_});
    return facts.engine;
  }
  void run(int frames, const Costs& costs) {
    for (int frame = 0; frame < frames; ++frame) run(costs);
  }

  EngineChoice choice_{Engine::kAuto};
  Engine last_ = Engine::kAuto;
  bool octree_looks_wrong_ = false;
  double spent_ = 0;
  int trials_ = 0;
};

TEST_F(Choice, IsWhatWasAskedFor) {
  choice_ = EngineChoice(Engine::kUniformGrid);
  octree_looks_wrong_ = true;
  run(100, {.octree = 9});
  EXPECT_EQ(choice_.next().engine, Engine::kUniformGrid);
  EXPECT_EQ(choice_.next().reason, EngineReason::kAsked);
}

TEST_F(Choice, KeepsTheOctreeWhereItIsFaster) {
  EXPECT_EQ(choice_.next().reason, EngineReason::kFirst);
  run(32, {.octree = 1, .lbvh = 1.5});
  const EngineFacts facts = choice_.next();
  EXPECT_EQ(facts.engine, kOctree);
  EXPECT_EQ(facts.reason, EngineReason::kFaster);
  EXPECT_EQ(facts.octree_milliseconds, 1);
  EXPECT_EQ(facts.lbvh_milliseconds, 1.5);
}

TEST_F(Choice, TakesTheHierarchyWhereThatIsFaster) {
  run(32, {.octree = 1.5, .lbvh = 1});
  EXPECT_EQ(choice_.next().engine, kLbvh);
  EXPECT_EQ(choice_.next().octree_milliseconds, 1.5);
  EXPECT_EQ(choice_.next().lbvh_milliseconds, 1);
}

TEST_F(Choice, StaysWhereTheGainIsNoise) {
  run(32, {.octree = 1, .lbvh = 0.98});
  EXPECT_EQ(choice_.next().engine, kOctree);
}

// Whichever it is, by however much: at most 0.75 % of the time, and the first comparison.
TEST_F(Choice, ComparesRarely) {
  for (const double lbvh : {0.1, 0.5, 0.9, 1.0, 1.1, 1.9, 5.0, 100.0}) {
    const Costs costs{.octree = 1, .lbvh = lbvh};
    choice_ = EngineChoice(Engine::kAuto);
    trials_ = 0;
    run(32, costs);
    spent_ = 0;
    run(20'000, costs);
    EXPECT_LE(spent_, 1.008 * 20'000 * (std::min(1.0, lbvh) + costs.others)) << lbvh;
    EXPECT_GE(trials_, 2) << lbvh;
    EXPECT_LE(trials_, 20'000 / 100) << lbvh;
    EXPECT_EQ(choice_.settled().engine, lbvh < 1 ? kLbvh : kOctree) << lbvh;
  }
}

TEST_F(Choice, KnowsAHopelessEngineByItsFirstFrame) {
  run(32, {.octree = 1, .lbvh = 50});
  EXPECT_EQ(trials_, 1);
}

// After the first 32 frames the engine in use is rarely the slower one by a twentieth, although single frames take up
// to three times as long as they should.
TEST_F(Choice, IsNotMisledByNoise) {
  std::mt19937 random(17);
  std::normal_distribution<double> jitter(1, 0.05);
  std::uniform_real_distribution<double> uniform(0, 1);
  int wrong = 0;
  constexpr int kScenes = 300;
  for (int scene = 0; scene < kScenes; ++scene) {
    choice_ = EngineChoice(Engine::kAuto);
    last_ = Engine::kAuto;
    const Costs costs{.octree = 1, .lbvh = scene % 2 == 0 ? 1.3 : 1 / 1.3};
    for (int frame = 0; frame < 32; ++frame) run(costs, jitter(random) * (uniform(random) < 0.05 ? 3 : 1));
    wrong += choice_.settled().engine != (costs.lbvh < 1 ? kLbvh : kOctree);
  }
  EXPECT_LE(wrong, kScenes / 25);
}

TEST_F(Choice, FollowsASceneThatBecomesAnother) {
  run(3000, {.octree = 1, .lbvh = 2});
  ASSERT_EQ(choice_.settled().engine, kOctree);
  const Costs now{.octree = 6, .lbvh = 2};
  int frames = 0;
  while (choice_.settled().engine == kOctree && frames < 1000) run(now), ++frames;
  EXPECT_LE(frames, 100);
}

// An engine that is 1.6 times slower, as the hierarchy is where many bodies collide: of the first thousand frames few
// are trials, the first comparison among them.
TEST_F(Choice, CostsLittleFromTheBeginning) {
  const Costs costs{.octree = 1.4, .lbvh = 2.6, .others = 0.6, .beginning = 3};
  run(1000, costs);
  EXPECT_LE(trials_, 10);
  EXPECT_LE(spent_ - costs.beginning, 1.01 * 1000 * (costs.octree + costs.others));
}

// The engine in use takes another time from then on, which is seen at once, whatever comparisons have cost so far.
TEST_F(Choice, LosesLittleWhereTheBestEngineChanges) {
  for (const int period : {200, 500, 2000}) {
    choice_ = EngineChoice(Engine::kAuto);
    last_ = Engine::kAuto;
    spent_ = 0;
    const Costs even{.octree = 1, .lbvh = 2}, odd{.octree = 3, .lbvh = 1};
    constexpr int kPeriods = 20;
    for (int i = 0; i < kPeriods; ++i) run(period, i % 2 == 0 ? even : odd);
    const double best = kPeriods * period * (1 + even.others);
    EXPECT_LE(spent_, (1 + 30.0 / period) * best) << period;
  }
}

// A time that changes although the best engine stays the same ends in fewer and fewer comparisons.
TEST_F(Choice, IsNotMadeToCompareByTimesThatChange) {
  for (int i = 0; i < 100; ++i) {
    const double size = i % 2 == 0 ? 1 : 3;
    run(100, {.octree = size, .lbvh = 1.6 * size});
  }
  EXPECT_EQ(choice_.settled().engine, kOctree);
  EXPECT_LE(trials_, 10'000 / 100);
}

TEST_F(Choice, GoesByCountersUntilItHasMeasured) {
  octree_looks_wrong_ = true;
  const Costs costs{.octree = 0.5, .lbvh = 1};
  EXPECT_EQ(run(costs), kOctree);
  EXPECT_EQ(choice_.next().engine, kLbvh);
  EXPECT_EQ(choice_.next().reason, EngineReason::kCounters);
  run(31, costs);
  EXPECT_EQ(choice_.next().engine, kOctree);  // the faster one, whatever it looks like
  EXPECT_EQ(choice_.next().reason, EngineReason::kFaster);
}

TEST_F(Choice, LeavesAnOctreeThatLooksWrongOfASudden) {
  const Costs costs{.octree = 1, .lbvh = 2};
  run(100, costs);
  ASSERT_EQ(choice_.next().engine, kOctree);
  octree_looks_wrong_ = true;
  run(costs);
  EXPECT_EQ(choice_.next().engine, kLbvh);
}

TEST_F(Choice, GivesUpAnEngineThatFindsNoRoom) {
  const Costs costs{.octree = 1, .lbvh = 0.5};
  EXPECT_FALSE(choice_.retreat());  // there is no other engine yet
  while (choice_.next().reason != EngineReason::kTrial) run(costs);
  EXPECT_TRUE(choice_.retreat());
  EXPECT_EQ(choice_.next().engine, kOctree);
  EXPECT_FALSE(choice_.retreat());
  trials_ = 0;
  run(10'000, costs);
  EXPECT_EQ(trials_, 0);
}

TEST_F(Choice, ReturnsToTheOctreeWhereTheHierarchyFindsNoRoom) {
  octree_looks_wrong_ = true;
  run({});
  ASSERT_EQ(choice_.next().engine, kLbvh);
  EXPECT_TRUE(choice_.retreat());
  run(10, {});
  EXPECT_EQ(choice_.next().engine, kOctree);
}

TEST_F(Choice, EndsAComparisonWhoseFrameDoesNotEnd) {
  while (choice_.next().reason != EngineReason::kTrial) run({});
  choice_.abandon();
  EXPECT_EQ(choice_.next().engine, kOctree);
  choice_.abandon();  // nothing to end
  EXPECT_EQ(choice_.next().engine, kOctree);
}

// Without the bound, a comparison could take a thousand times as long as any frame before.
TEST_F(Choice, BoundsTheFramesOfAComparison) {
  while (choice_.next().reason != EngineReason::kTrial) {
    EXPECT_EQ(choice_.longest_trial(), 0);
    run({.octree = 100, .lbvh = 100});
  }
  EXPECT_GE(choice_.longest_trial(), 2 * 100.5);
  EXPECT_LE(choice_.longest_trial(), 20 * 100.5);
}

TEST_F(Choice, BeginsWithTheHierarchyWhereRulesKeepPairsApart) {
  EXPECT_EQ(EngineChoice(Engine::kAuto, rivals_of(100'000, false, true)).next().engine, kLbvh);
  choice_ = EngineChoice(Engine::kAuto, rivals_of(500, false, true));
  EXPECT_EQ(choice_.next().engine, Engine::kAllPairs);
  while (choice_.next().reason != EngineReason::kTrial) run({});
  EXPECT_EQ(choice_.next().engine, kLbvh);
}

TEST_F(Choice, WaitsForFramesThatTellSomething) {
  for (int frame = 0; frame < 100; ++frame) choice_.observe({1, 1, false, false});
  EXPECT_EQ(choice_.next().reason, EngineReason::kFirst);
}

TEST(EngineChoices, LookWrongIfTestsOrRegistrationsDo) {
  const auto counts = [](uint64_t tests, uint64_t pairs, uint64_t registrations) {
    FrameCounts c;
    c.tests = tests, c.pairs = pairs, c.registrations = registrations;
    return c;
  };
  EXPECT_FALSE(looks_wrong(counts(80'000, 15'000, 4000), 1000, false));    // a cloth
  EXPECT_FALSE(looks_wrong(counts(600'000, 500'000, 1000), 1000, false));  // all in one place: tests find pairs
  EXPECT_TRUE(looks_wrong(counts(2'000'000, 20'000, 2000), 1000, false));  // in vain
  EXPECT_TRUE(looks_wrong(counts(20'000, 20'000, 24'001), 1000, false));
  EXPECT_TRUE(looks_wrong(counts(30'000, 20'000, 4000), 1000, true));  // mixed scale
}

TEST(EngineChoices, MeasureTheLastStepsSearch) {
  EXPECT_EQ(search_milliseconds({{"upload", 64},
                                 {"boxes", 32},
                                 {"pairs", 16},
                                 {"narrow_vt", 8},
                                 {"boxes", 4},
                                 {"count", 2},
                                 {"pairs", 1},
                                 {"order", 128}}),
            7);
}

TEST_F(Choice, ComparesTheRivalsOfSmallScenes) {
  choice_ = EngineChoice(Engine::kAuto, rivals_of(500, false, false));
  EXPECT_EQ(choice_.next().engine, Engine::kAllPairs);
  run(32, {.octree = 0.5, .lbvh = 1});  // the second is what all pairs take
  const EngineFacts facts = choice_.next();
  EXPECT_EQ(facts.engine, kOctree);
  EXPECT_EQ(facts.octree_milliseconds, 0.5);
  EXPECT_EQ(facts.all_pairs_milliseconds, 1);
  EXPECT_EQ(facts.lbvh_milliseconds, 0);
}

// A GPU takes longer to launch anything than to search so few.
TEST_F(Choice, TriesNothingWhereLaunchesCostMore) {
  choice_ = EngineChoice(Engine::kAuto, rivals_of(2000, true, false));
  run(10'000, {.octree = 0.5, .lbvh = 1});
  EXPECT_EQ(trials_, 0);
  EXPECT_EQ(choice_.next().engine, Engine::kAllPairs);
  EXPECT_EQ(choice_.next().reason, EngineReason::kFirst);
  EXPECT_EQ(EngineChoice(kOctree, rivals_of(2000, true, false)).next().engine, kOctree);  // what a scene asks for
}

// An edit that makes a scene small, or large.
TEST(EngineChoices, BeginAnewWithOtherRivals) {
  LevelNeeds needs;
  EngineChoices choices(Engine::kAuto, rivals_of(500, false, false));
  EXPECT_EQ(choices.begin(needs).engine, Engine::kAllPairs);
  choices.choose_between(rivals_of(100'000, false, false));
  EXPECT_EQ(choices.begin(needs).engine, kOctree);
  EngineChoices asked(kLbvh, rivals_of(500, false, false));
  asked.choose_between(rivals_of(100'000, false, false));
  EXPECT_EQ(asked.begin(needs).engine, kLbvh);
}

TEST(EngineChoices, KnowWhoIsIdle) {
  EngineChoices choices(Engine::kAuto);
  LevelNeeds needs;
  needs.settings.mode = Mode::kCcd;
  EXPECT_EQ(choices.begin(needs).engine, kOctree);
  EXPECT_FALSE(choices.is_idle(kOctree));
  EXPECT_TRUE(choices.is_idle(kLbvh));
  EXPECT_FALSE(EngineChoices(kOctree).is_idle(kLbvh));  // nothing is given back where nothing is compared
}

}  // namespace
}  // namespace collided::test
