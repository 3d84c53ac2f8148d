// When a stream sends, and what is counted: above all the frames behind one that takes long.

#include "client/measure/load/drive/stream_pace.hpp"

#include <gtest/gtest.h>

namespace collided::cli::load {
namespace {

using std::chrono::milliseconds;

const Time kStart = Time() + std::chrono::hours(1);
Time at(int ms) { return kStart + milliseconds(ms); }

v1::StreamFramesResponse done() {
  v1::StreamFramesResponse out;
  v1::FrameMetrics& metrics = *out.mutable_done()->mutable_metrics();
  metrics.set_total_milliseconds(0.5);
  metrics.set_queue_milliseconds(0.25);
  return out;
}

class LoadStreamPace : public testing::Test {
 protected:
  void begin(Phase phase, uint32_t window = 2) {
    phase.start = kStart;
    pace_.open(window);
    pace_.written(kStart);  // the opening
    pace_.begin(phase, {});
  }
  /// Sends what is due by then, one after the other.
  void send_due(Time now) {
    while (pace_.due() <= now && pace_.can_send()) {
      pace_.send(now, books());
      pace_.written(now);
    }
  }
  void answer(Time now, const v1::StreamFramesResponse& message = done()) { pace_.take(message, now, books()); }
  void finish() {
    for (int i = 0; i < 10; ++i) {
      answer(at(1000));
      send_due(at(1000));
    }
    EXPECT_TRUE(pace_.is_idle());
  }
  Books books() { return {tally_, second_}; }

  StreamPace pace_;
  Tally tally_;
  Second second_;
};

TEST_F(LoadStreamPace, FramesBehindALateOneCountFromWhenTheyWereDue) {
  const RateProfile profile(100, 1);  // every 10 ms
  begin({.profile = &profile});
  for (int ms = 0; ms < 1000; ms += 10) {
    send_due(at(ms));
    if (ms < 200 || ms >= 700) answer(at(ms + 1));  // it stands still from 200 to 700
    for (int i = 0; ms == 700 && i < 60; ++i) {     // then it answers all that has queued up
      answer(at(700));
      send_due(at(700));
    }
  }
  finish();
  EXPECT_EQ(tally_.sent, 100U);
  EXPECT_EQ(tally_.answered, 100U);
  EXPECT_NEAR(tally_.latency.max(), 500, 11);
  EXPECT_NEAR(tally_.latency.percentile(75), 250, 20);  // half of the frames of the run waited, 250 ms on average
  EXPECT_LT(tally_.service.percentile(95), 20);         // which the frames that were sent do not show
  EXPECT_LE(tally_.delay.max(), 0);                     // nor was it the tester
}

TEST_F(LoadStreamPace, AClosedLoopSeesAStandstillOnlyInTheFramesOfItsWindow) {
  begin({});
  for (int ms = 0; ms < 1000; ++ms) {
    send_due(at(ms));
    if (ms < 200 || ms >= 700) answer(at(ms + 1));
  }
  pace_.stop();
  finish();
  EXPECT_GE(tally_.latency.max(), 500);
  EXPECT_LT(tally_.latency.percentile(99), 10);
  EXPECT_EQ(tally_.unsent, 0U);
}

TEST_F(LoadStreamPace, TheWindowAndTheConnectionHoldFramesBack) {
  const RateProfile profile(100, 1);
  begin({.profile = &profile}, 2);
  EXPECT_EQ(pace_.send(at(0), books()), 1U);
  EXPECT_FALSE(pace_.can_send());  // the connection still has the first
  pace_.written(at(0));
  EXPECT_EQ(pace_.send(at(10), books()), 2U);
  pace_.written(at(10));
  EXPECT_FALSE(pace_.can_send());
  answer(at(25));
  ASSERT_TRUE(pace_.can_send());
  EXPECT_EQ(pace_.due(), at(20));
  pace_.send(at(28), books());
  EXPECT_DOUBLE_EQ(tally_.delay.max(), 3);  // since there was room, not since it was due
}

TEST_F(LoadStreamPace, WhatIsNotAnsweredCountsWithTheTimeThatItWaited) {
  const RateProfile profile(100, 0.1);  // 10 frames
  begin({.profile = &profile}, 2);
  send_due(at(0));
  send_due(at(10));
  pace_.give_up(at(1000), tally_);
  EXPECT_EQ(tally_.unanswered, 2U);
  EXPECT_EQ(tally_.unsent, 8U);
  EXPECT_EQ(tally_.due(), 10U);
  EXPECT_NEAR(tally_.latency.min(), 910, 1);
  EXPECT_NEAR(tally_.latency.max(), 1000, 1);
  answer(at(2000));  // too late to be counted again
  answer(at(2000));
  EXPECT_TRUE(pace_.is_idle());
  EXPECT_EQ(tally_.answered, 0U);
  EXPECT_EQ(tally_.late, 2U);
  EXPECT_EQ(tally_.latency.count(), 10U);
}

TEST_F(LoadStreamPace, SkippedAndRefusedFramesAreCountedApart) {
  begin({.max_frames = 3}, 3);
  send_due(at(0));
  v1::StreamFramesResponse skipped, refused;
  skipped.mutable_skipped();
  refused.mutable_error()->set_code(8);
  refused.mutable_error()->set_message("max_frames_per_second is 50");
  answer(at(1), skipped);
  answer(at(1), refused);
  answer(at(2));
  EXPECT_EQ(tally_.skipped, 1U);
  EXPECT_EQ(tally_.answered, 1U);
  EXPECT_EQ(tally_.latency.count(), 1U);
  EXPECT_EQ(tally_.refused.at("RESOURCE_EXHAUSTED").first, "max_frames_per_second is 50");
  EXPECT_EQ(second_.refused, 1U);
  EXPECT_TRUE(pace_.is_idle());
}

TEST_F(LoadStreamPace, AClosedLoopWaitsAsLongAsARefusalAsksFor) {
  begin({}, 1);
  send_due(at(0));
  v1::StreamFramesResponse refused;
  refused.mutable_error()->set_code(8);
  refused.mutable_error()->set_retry_after_seconds(0.5);
  answer(at(10), refused);
  EXPECT_EQ(pace_.due(), at(510));
}

TEST_F(LoadStreamPace, AStreamOutsideOfThePhaseSendsNothing) {
  begin({.max_frames = 3, .first_stream = 1});
  EXPECT_TRUE(pace_.is_idle());
}

}  // namespace
}  // namespace collided::cli::load
