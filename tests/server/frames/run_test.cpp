// How long a frame may run.
#include "server/frames/run.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <optional>

#include "server/errors.hpp"
#include "tests/server/frames/session_test.hpp"
#include "tests/server/hand_clock.hpp"

namespace collided::server {
namespace {

// Each reading of the clock takes a second.
class SlowClock {
 public:
  Now now() const {
    return [this] {
      clock_.move(std::chrono::seconds(1));
      return clock_.now()();
    };
  }

 private:
  const HandClock clock_;
};

TEST(FrameRun, AFrameThatRunsForTooLongIsRefusedAndTheSceneGoesOn) {
  const SlowClock clock;
  SceneBench bench(64, Turns::Options{.concurrent = 1, .now = clock.now()});
  const auto hasty = client("hasty", {.max_frame_seconds = 2.5});
  const auto scene = bench.add(hasty, {tip_plan(), "", 0, 30});
  PendingFrame frame = tip_frame(1, 2);
  try {
    run_frame(*scene, frame, {});
    FAIL() << "no limit";
  } catch (const LimitExceeded& e) {
    EXPECT_EQ(e.subject(), "client:hasty");
    const std::string text = e.what();
    EXPECT_EQ(text.find("max_frame_seconds is 2.5, and frame 1 has run for "), 0u) << text;
    for (const char* help : {"any_hit", "earliest_only", "--max-frame-seconds"})
      EXPECT_NE(text.find(help), std::string::npos) << text;
  }
  EXPECT_EQ(scene->snapshot().last_frame_id, 0u);
  const auto other = bench.add(client("patient", {.max_frame_seconds = 1e6}), {tip_plan(), "", 0, 30});
  PendingFrame again = tip_frame(1, 2);
  EXPECT_EQ(run_frame(*other, again, {}).result.vertex_triangle.size(), 1u);
}

// The time in which others ran does not count.
TEST(FrameRun, TheWaitForATurnDoesNotCount) {
  const HandClock clock;
  SceneBench bench(64, Turns::Options{.concurrent = 1, .now = clock.now()});
  const auto scene = bench.add(client("hasty", {.max_frame_seconds = 2.5}), {tip_plan(), "", 0, 30});
  TurnAccount other;
  std::optional turn = bench.devices.turns({}).take(other);
  PendingFrame frame = tip_frame(1, 2);
  std::atomic<int> looks = 0;
  auto contacts = std::async(std::launch::async, [&] {
    return run_frame(*scene, frame, [&] { return ++looks < 0; }).result.vertex_triangle.size();
  });
  EXPECT_TRUE(wait_until([&] { return looks >= 2; }));  // the second of them while it waits
  clock.move(std::chrono::seconds(100));
  turn.reset();
  EXPECT_EQ(contacts.get(), 1u);
}

}  // namespace
}  // namespace collided::server
