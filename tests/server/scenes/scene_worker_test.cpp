// The worker: order, bound, and an end on its own thread.
#include "server/scenes/scene_worker.hpp"

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <vector>

namespace collided::server {
namespace {

TEST(SceneWorker, RunsInOrder) {
  SceneWorker worker(100);
  std::vector<int> seen;
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(worker.try_post([&seen, i] { seen.push_back(i); }));
  worker.flush();
  ASSERT_EQ(seen.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(seen[i], i);
}

TEST(SceneWorker, RefusesFramesPastItsCapacityButNoControlWork) {
  SceneWorker worker(1);
  std::promise<void> started, go;
  worker.post([&] {
    started.set_value();
    go.get_future().wait();
  });
  started.get_future().wait();
  EXPECT_TRUE(worker.try_post([] {}));
  EXPECT_FALSE(worker.try_post([] {}));
  worker.post([] {});
  go.set_value();
  worker.flush();
  EXPECT_TRUE(worker.try_post([] {}));
}

TEST(SceneWorker, CanEndOnItsOwnThread) {
  std::promise<void> gone;
  auto worker = std::make_shared<SceneWorker>(1);
  auto* raw = worker.get();
  std::promise<void> go;
  raw->post([held = worker, &go, &gone]() mutable {
    go.get_future().wait();
    held.reset();
    gone.set_value();
  });
  worker.reset();
  go.set_value();
  gone.get_future().wait();
}

// What posts a job must not touch the worker any more: with it gone, a sanitizer would tell.
TEST(SceneWorker, MayBeGoneBeforeItsLastJobHasBeenPosted) {
  for (int i = 0; i < 300; ++i) {
    auto worker = std::make_shared<SceneWorker>(1);
    SceneWorker& target = *worker;
    target.post([held = std::move(worker)]() mutable { held.reset(); });
  }
}

}  // namespace
}  // namespace collided::server
