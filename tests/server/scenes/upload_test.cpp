// Uploads: the memory they hold, and how they end.
#include "server/scenes/upload.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/errors.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

using std::chrono::seconds;

constexpr auto kLimit = seconds(10);

class UploadTest : public testing::Test {
 protected:
  // The tip awaits 100 triangles.
  SceneUse make_scene() {
    ScenePlan plan = tip_plan(100);
    plan.quota = held_;
    return scenes_.scenes.add(client(), {std::move(plan), "", 0, 30}).scene;
  }
  std::shared_ptr<Upload> make_upload() {
    return std::make_shared<Upload>(
        [this](const std::exception_ptr& why) {
          try {
            std::rethrow_exception(why);
          } catch (const TimedOut&) {
            ends_.emplace_back("TimedOut");
          } catch (const NotFound&) {
            ends_.emplace_back("NotFound");
          }
        },
        start_);
  }
  // Has received `count` triangles and waits for more.
  std::shared_ptr<Upload> make_waiting(uint64_t count = 10) {
    auto upload = make_upload();
    upload->begin(scene_, 1, nullptr);
    bring(*upload, count);
    upload->wait([] {});
    return upload;
  }
  static void bring(Upload& upload, uint64_t count) {
    upload.reserve(count);
    for (uint64_t i = 0; i < count; ++i) upload.triangles().push({0, 1, 2});
  }

  const Upload::Clock::time_point start_ = Upload::Clock::now();
  const std::shared_ptr<DeviceBytes> held_ = std::make_shared<DeviceBytes>("daemon", "limit", 1 << 20);
  SceneBench scenes_;
  SceneUse scene_ = make_scene();
  const uint64_t before_ = held_->held();
  std::vector<std::string> ends_;
};

TEST_F(UploadTest, WhatCameCountsAndWhatWasAnnouncedDoesNot) {
  EXPECT_LT(before_, 2000u);
  const auto upload = make_waiting(10);
  EXPECT_EQ(held_->held(), before_ + 10 * 12);
  EXPECT_EQ(scene_->snapshot().memory.at(0).bytes, before_ + 10 * 12);
  ASSERT_TRUE(upload->receive(start_));
  bring(*upload, 90);
  EXPECT_EQ(held_->held(), before_ + 100 * 12);
  EXPECT_THROW(upload->reserve(1), InvalidInput);
  EXPECT_TRUE(upload->end());
  EXPECT_EQ(held_->held(), before_);
}

TEST_F(UploadTest, MoreThanTheLimitIsRefused) {
  const auto upload = make_upload();
  upload->begin(scene_, 1, nullptr);
  held_->set_max(before_ + 100);
  EXPECT_THROW(upload->reserve(10), LimitExceeded);
  EXPECT_EQ(held_->held(), before_);
}

TEST_F(UploadTest, ASilentOneEndsOnceAndItsMeshIsFree) {
  const auto upload = make_waiting();
  upload->end_if_stale(start_ + kLimit, kLimit);
  EXPECT_TRUE(ends_.empty());
  EXPECT_THROW(scene_->uploads().begin(1), FailedPrecondition);
  for (int i = 1; i < 3; ++i) upload->end_if_stale(start_ + kLimit + seconds(i), kLimit);
  EXPECT_EQ(ends_, std::vector<std::string>{"TimedOut"});
  EXPECT_EQ(held_->held(), before_);
  EXPECT_FALSE(upload->receive(start_));
  EXPECT_FALSE(upload->end());
  EXPECT_NO_THROW(scene_->uploads().begin(1));
}

TEST_F(UploadTest, AChunkBeginsTheTimeAnew) {
  const auto upload = make_waiting();
  ASSERT_TRUE(upload->receive(start_ + seconds(9)));
  upload->end_if_stale(start_ + seconds(1000), kLimit);  // at work
  upload->wait([] {});
  upload->end_if_stale(start_ + seconds(19), kLimit);
  EXPECT_TRUE(ends_.empty());
  upload->end_if_stale(start_ + seconds(20), kLimit);
  EXPECT_EQ(ends_.size(), 1u);
}

TEST_F(UploadTest, OneWithoutAChunkEndsToo) {
  const auto upload = make_upload();
  upload->wait([] {});
  upload->end_if_stale(start_ + seconds(11), kLimit);
  EXPECT_EQ(ends_, std::vector<std::string>{"TimedOut"});
}

// As where a call is evicted before it first waits for a chunk.
TEST_F(UploadTest, OneThatHasEndedWaitsForNothing) {
  const auto upload = make_upload();
  EXPECT_TRUE(upload->end());
  upload->wait([] { FAIL() << "the call is over"; });
  EXPECT_FALSE(upload->receive(start_));
  EXPECT_FALSE(upload->end());
}

TEST_F(UploadTest, OneWhoseSceneIsDeletedEndsAtOnce) {
  const auto upload = make_waiting();
  scenes_.scenes.remove(client(), scene_->id())->release();
  OpenUploads open;
  open.add(upload);
  open.end_stale(start_, kLimit);
  EXPECT_EQ(ends_, std::vector<std::string>{"NotFound"});
  EXPECT_EQ(held_->held(), 0u);
}

TEST_F(UploadTest, ASceneIsInUseUntilItsUploadEnds) {
  const auto upload = make_waiting();
  scene_ = {};
  const auto later = start_ + seconds(3600);
  EXPECT_TRUE(scenes_.scenes.remove_expired(later).empty());
  upload->end_if_stale(later, kLimit);
  EXPECT_EQ(scenes_.scenes.remove_expired(later).size(), 1u);
}

TEST_F(UploadTest, ReceivedTrianglesBecomeTheScenesOwn) {
  const auto upload = make_waiting(100);
  ASSERT_TRUE(upload->receive(start_));
  scene_->add_triangles(1, upload->triangles());
  EXPECT_TRUE(upload->end());
  const auto shown = scene_->snapshot();
  EXPECT_TRUE(shown.ready);
  uint64_t bytes = 0;
  for (const auto& part : shown.memory) bytes += part.bytes;
  EXPECT_EQ(held_->held(), bytes);
}

}  // namespace
}  // namespace collided::server
