// What a flood is, and what is none.
#include "server/net/flood_meter.hpp"

#include <gtest/gtest.h>

#include <string>

namespace collided::server {
namespace {

using std::chrono::milliseconds;

constexpr uint64_t kKilobyte = 1 << 10, kMegabyte = 1 << 20;

/// A connection whose caller is known, looked at ten times a second.
class Metered : public testing::Test {
 protected:
  void reads(uint64_t bytes) {
    traffic_.received += bytes;
    traffic_.read += bytes;
  }
  void sends(uint64_t bytes) {
    traffic_.sent += bytes;
    traffic_.acknowledged += bytes;
  }
  void receives_message(uint64_t bytes) {
    reads(bytes + bytes / 1000);
    sends(13);
    meter_.received(bytes);
  }
  void sends_message(uint64_t bytes) {
    meter_.sent(bytes);
    sends(bytes + bytes / 500);
  }
  std::string look() {
    meter_.prepare_look();
    return look_at(traffic_);
  }
  std::string look_at(const Traffic& traffic) {
    return std::string(meter_.look(traffic, now_ += milliseconds(100), is_known_));
  }
  /// What is said in so many looks, each after `something`.
  template <class Something>
  std::string said(int looks, Something something) {
    std::string what;
    for (int i = 0; i < looks && what.empty(); ++i) {
      something();
      what = look();
    }
    return what;
  }

  FloodMeter::Time now_{};
  Traffic traffic_;
  FloodMeter meter_{now_};
  bool is_known_ = true;
};

TEST_F(Metered, AConnectionWithoutACallHasAMegabyteAndMoreWithTime) {
  is_known_ = false;
  EXPECT_EQ(said(1000, [&] { reads(6 * kKilobyte); }), "");
  reads(kMegabyte + 8 * kKilobyte);
  EXPECT_EQ(look(), "bytes without a call");
  is_known_ = true;
  EXPECT_EQ(look(), "");
}

TEST_F(Metered, FramesThatNeedNoWindowAreAFlood) {
  EXPECT_EQ(said(100, [&] { reads(8 * kMegabyte); }), "frames that need no window");
  EXPECT_LE(traffic_.read, 48 * kMegabyte);
}

TEST_F(Metered, WhatIsReadBetweenTwoWindowsIsNone) {
  EXPECT_EQ(said(100,
                 [&] {
                   receives_message(500 * kMegabyte);
                   receives_message(500 * kMegabyte);
                 }),
            "");
  reads(100 * kMegabyte);  // at once
  EXPECT_EQ(look(), "");
}

// Each has a window of its own.
TEST_F(Metered, ManyCallsMayFillTheirWindows) {
  for (int i = 0; i < 20; ++i) meter_.began();
  EXPECT_EQ(said(13, [&] { reads(8 * kMegabyte); }), "");
  for (int i = 0; i < 20; ++i) meter_.ended();
  EXPECT_EQ(look(), "");  // they were open when it was sent
  sends(13);
  EXPECT_EQ(said(100, [&] { reads(8 * kMegabyte); }), "frames that need no window");
  meter_.ended();  // of an earlier connection
  meter_.began();
  sends(13);
  EXPECT_EQ(said(4, [&] { reads(8 * kMegabyte); }), "");
}

TEST_F(Metered, WhatTheKernelHoldsUnreadIsNone) {
  EXPECT_EQ(said(100, [&] { traffic_.received += 8 * kMegabyte; }), "");
}

TEST_F(Metered, FramesThatAreAnsweredAreAFlood) {
  const auto settings = [&] {
    reads(1500 * kKilobyte);
    sends(900 * kKilobyte);
  };
  EXPECT_EQ(said(100, settings), "frames that are answered");
  EXPECT_LE(traffic_.sent, 5 * kMegabyte);
}

TEST_F(Metered, CallsAndTheirAnswersAreNone) {
  EXPECT_EQ(said(10'000,
                 [&] {
                   for (int i = 0; i < 100; ++i) {
                     receives_message(200);
                     reads(2 * kKilobyte);  // headers
                     sends(kKilobyte);
                     sends_message(300);
                   }
                 }),
            "");
}

TEST_F(Metered, AnswersOfAnySizeAreNone) {
  EXPECT_EQ(said(10'000,
                 [&] {
                   receives_message(10);
                   sends_message(100 * kMegabyte);
                 }),
            "");
}

// Pings of a connection that stays open for a year.
TEST_F(Metered, KeepaliveIsNone) {
  const auto ping = [&] {
    now_ += std::chrono::seconds(10);
    reads(17);
    sends(17);
  };
  EXPECT_EQ(said(3'000'000, ping), "");
}

TEST_F(Metered, AMessageIsUnfinishedUntilItHasCome) {
  const auto part = [&] {
    reads(kMegabyte);
    sends(26);
  };
  EXPECT_EQ(said(128, part), "");
  EXPECT_GT(meter_.unfinished(), 64 * kMegabyte);
  EXPECT_LE(meter_.unfinished(), 128 * kMegabyte);
  meter_.received(128 * kMegabyte);
  EXPECT_EQ(look(), "");
  EXPECT_EQ(meter_.unfinished(), 0u);
  EXPECT_EQ(said(128, part), "");
  EXPECT_GT(meter_.unfinished(), 64 * kMegabyte);  // nothing is left over of the first
}

// Otherwise each look would lose what comes while a busy machine is at it.
TEST_F(Metered, AMessageThatComesDuringALookIsNotForgotten) {
  for (int i = 0; i < 100; ++i) {
    const Traffic before = traffic_;
    meter_.prepare_look();
    receives_message(100 * kMegabyte);
    EXPECT_EQ(look_at(before), "");
  }
  EXPECT_EQ(look(), "");
  EXPECT_LE(meter_.unfinished(), 1 * kMegabyte);
}

TEST_F(Metered, WhatComesBetweenMessagesStaysUnfinished) {
  const auto noise = [&] {
    reads(2 * kMegabyte);
    receives_message(10);
    sends_message(10);
  };
  EXPECT_EQ(said(100, noise), "");
  EXPECT_GT(meter_.unfinished(), 100 * kMegabyte);
}

}  // namespace
}  // namespace collided::server
