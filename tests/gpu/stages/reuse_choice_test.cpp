// Whether a scene goes by lists of neighbours, and how long they are meant to last, from times that the tests give.

#include <gtest/gtest.h>

#include "gpu/step/plan/reuse_planner.hpp"

namespace collided::test {
namespace {

/// A scene, in milliseconds.
struct Costs {
  double search = 1, make = 2, reuse = 0.2;
  double for_length = 0;  ///< what each frame that a list is meant for adds to frames that reuse it
  int lasts = 1 << 20;    ///< frames, at most
};

class ReuseTimes : public ::testing::Test {
 protected:
  /// A frame as it is chosen; whether with lists.
  bool run(const Costs& costs) {
    ++frames_;
    if (!choice_.uses_lists()) {
      left_ = 0;
      spend(ListUse::kNone, costs.search);
      return false;
    }
    if (left_ > 0) {
      --left_;
      spend(ListUse::kReused, costs.reuse + costs.for_length * choice_.run_length());
      return true;
    }
    left_ = std::min(static_cast<int>(choice_.run_length()), costs.lasts);
    spend(ListUse::kMade, costs.make);
    return true;
  }
  void run(int frames, const Costs& costs) {
    for (int frame = 0; frame < frames; ++frame) run(costs);
  }

  ReuseChoice choice_{Reuse::kAuto};
  double spent_ = 0;
  int frames_ = 0;

 private:
  void spend(ListUse use, double milliseconds) {
    spent_ += milliseconds;
    choice_.observe(use, milliseconds, milliseconds, true);
  }
  int left_ = 0;
};

TEST_F(ReuseTimes, GiveUpListsThatTakeTooLongToMake) {
  EXPECT_EQ(choice_.longest_making(), 0);  // nothing is known of searches
  int tries = 0;
  for (int frame = 0; frame < 100'000; ++frame) {
    if (!choice_.uses_lists()) {
      choice_.observe(ListUse::kNone, 10, 10, true);
      continue;
    }
    EXPECT_EQ(choice_.longest_making(), 10 * (1 + choice_.run_length() / 2));
    choice_.give_up();
    EXPECT_EQ(choice_.facts().reason, ReuseReason::kSlower);
    EXPECT_EQ(choice_.run_length(), std::max(2.0, 4.0 / (1 << tries)));  // the next ones are to last less long
    ++tries;
  }
  EXPECT_GE(tries, 3);
  EXPECT_LE(tries, 20);
}

TEST_F(ReuseTimes, ShortFramesAreAllowedWhatAWaitForProcessorsTakes) {
  while (!choice_.uses_lists()) choice_.observe(ListUse::kNone, 0.1, 0.1, true);
  EXPECT_EQ(choice_.longest_making(), 3);
  ReuseChoice asked(Reuse::kOn);
  for (int frame = 0; frame < 10; ++frame) asked.observe(ListUse::kNone, 10, 10, true);
  EXPECT_EQ(asked.longest_making(), 0);
}

// On a device that many scenes use a search is as short as ever, and takes long to have its turn, as making does.
TEST_F(ReuseTimes, WaitsForABusyDeviceAreNotHeldAgainstLists) {
  while (!choice_.uses_lists()) choice_.observe(ListUse::kNone, 1, 40, true);
  EXPECT_EQ(choice_.longest_making(), 40 * (1 + choice_.run_length() / 2));
}

TEST_F(ReuseTimes, TakeListsWhereTheyPay) {
  EXPECT_EQ(choice_.facts().reason, ReuseReason::kFirst);
  run(1000, {});
  EXPECT_TRUE(choice_.uses_lists());
  const ReuseFacts facts = choice_.facts();
  EXPECT_EQ(facts.reason, ReuseReason::kFaster);
  EXPECT_EQ(facts.search_milliseconds, 1);
  EXPECT_LT(facts.list_milliseconds, 0.4);
  EXPECT_LT(spent_, 400);
}

TEST_F(ReuseTimes, SearchWhereListsDoNotPay) {
  for (const Costs& costs : {Costs{.reuse = 1.1}, Costs{.make = 9, .reuse = 0.9}, Costs{.make = 1.5, .lasts = 0}}) {
    choice_ = ReuseChoice(Reuse::kAuto);
    run(100, costs);
    EXPECT_FALSE(choice_.uses_lists());
    EXPECT_TRUE(choice_.is_idle());
    EXPECT_EQ(choice_.facts().reason, ReuseReason::kSlower);
  }
}

// Whatever lists cost: beyond the first comparisons, of engines and lengths, little of the time.
TEST_F(ReuseTimes, CompareRarely) {
  for (const double reuse : {0.1, 0.5, 0.9, 1.0, 1.5, 9.0}) {
    const Costs costs{.make = 2 * reuse + 1, .reuse = reuse};
    choice_ = ReuseChoice(Reuse::kAuto);
    run(100, costs);
    spent_ = 0;
    run(20'000, costs);
    const double best = std::min(1.0, choice_.uses_lists() ? choice_.facts().list_milliseconds : 1.0);
    EXPECT_LE(spent_ / 20'000, 1.05 * best) << reuse;
  }
}

TEST_F(ReuseTimes, FollowTheScene) {
  run(400, {});
  ASSERT_TRUE(choice_.uses_lists());
  run(1000, {.make = 3, .reuse = 2});
  EXPECT_FALSE(choice_.uses_lists());
  run(400, {.lasts = 0});  // everything moves too far
  EXPECT_FALSE(choice_.uses_lists());
}

// Long runs where lists cost no more for it, short ones where they do.
TEST_F(ReuseTimes, FindTheLengthOfRuns) {
  run(4000, {});
  EXPECT_EQ(choice_.run_length(), 64);
  choice_ = ReuseChoice(Reuse::kAuto);
  run(4000, {.for_length = 0.1});
  EXPECT_LE(choice_.run_length(), 8);
  EXPECT_GE(choice_.run_length(), 2);
}

TEST_F(ReuseTimes, AreNotAskedForWhatTheSpecSays) {
  choice_ = ReuseChoice(Reuse::kOff);
  run(100, {});
  EXPECT_FALSE(choice_.uses_lists());
  choice_ = ReuseChoice(Reuse::kOn);
  EXPECT_TRUE(choice_.uses_lists());
  run(200, {.make = 9, .reuse = 9});
  EXPECT_TRUE(choice_.uses_lists());
  EXPECT_EQ(choice_.facts().reason, ReuseReason::kAsked);
}

TEST_F(ReuseTimes, GiveUpListsThatHaveNoRoom) {
  run(400, {});
  ASSERT_TRUE(choice_.uses_lists());
  choice_.refuse();
  EXPECT_FALSE(choice_.uses_lists());
  EXPECT_EQ(choice_.facts().reason, ReuseReason::kNoRoom);
  run(10'000, {});
  EXPECT_FALSE(choice_.uses_lists());
  choice_ = ReuseChoice(Reuse::kOn);
  choice_.refuse();
  EXPECT_FALSE(choice_.uses_lists());
  run(100, {});
  EXPECT_TRUE(choice_.uses_lists());
}

class Lists : public ::testing::Test {
 protected:
  /// A step of vertices that leave their tracks by `off` as the square of the frames since they began.
  ListUse step(double off, const FrameSettings& settings = kSettings) {
    LevelNeeds needs;
    needs.settings = settings;
    ListPlan plan = planner_.begin(needs, kBounds);
    const TrackTimes times = planner_.times(plan);
    const double slack = times.margin - off * times.to * times.to;
    if (plan.use == ListUse::kReused && slack < 0) plan = planner_.miss({kBounds, slack, 0.1});
    planner_.end(plan, {kBounds, slack, 0.1}, 100, 1, 1, true);
    made_.push_back(plan);
    return plan.use;
  }

  static constexpr FrameSettings kSettings{Mode::kCcd, Accuracy::kCertified, 0, Report::kAll, 0.1, 0.1, false};
  static constexpr Box<float> kBounds{{0, 0, 0}, {1, 1, 1}};
  static SceneSpec spec() {
    SceneSpec spec;
    spec.reuse = Reuse::kOn;
    return spec;
  }
  const SceneSpec spec_ = spec();
  ReusePlanner planner_{spec_};
  std::vector<ListPlan> made_;
};

TEST_F(Lists, HaveTheMarginThatTheirFramesNeed) {
  EXPECT_EQ(step(1e-4), ListUse::kMade);
  EXPECT_EQ(step(1e-4), ListUse::kNone);  // nothing was known of how vertices move
  EXPECT_EQ(step(1e-4), ListUse::kMade);
  EXPECT_GE(made_.back().margin, 1e-4 * 64);
  EXPECT_LE(made_.back().margin, 2e-4 * 64);
  for (int frame = 0; frame < 8; ++frame) EXPECT_EQ(step(1e-4), ListUse::kReused) << frame;
  EXPECT_EQ(step(1e-4), ListUse::kMade);
}

TEST_F(Lists, ServeFramesThatReachNoFarther) {
  for (int frame = 0; frame < 3; ++frame) step(1e-6);
  ASSERT_EQ(step(1e-6), ListUse::kReused);
  FrameSettings other = kSettings;
  other.thickness = other.start_thickness = 0.05;
  EXPECT_EQ(step(1e-6, other), ListUse::kReused);
  other.thickness = 0.2;
  EXPECT_EQ(step(1e-6, other), ListUse::kMade);
  other.delta = 0.01;
  EXPECT_EQ(step(1e-6, other), ListUse::kMade);
  EXPECT_EQ(step(1e-6), ListUse::kReused);
  other.accuracy = Accuracy::kFast;
  EXPECT_EQ(step(1e-6, other), ListUse::kNone);
  EXPECT_EQ(step(1e-6), ListUse::kReused);
  planner_.forget();
  EXPECT_EQ(step(1e-6), ListUse::kMade);
}

}  // namespace
}  // namespace collided::test
