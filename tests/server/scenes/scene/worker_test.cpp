// The worker: order, bound, and an end on its own thread.
#include "server/scenes/scene/worker.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <array>
#include <chrono>
#include <future>
#include <memory>
#include <new>
#include <thread>
#include <vector>

#include "tests/support/sanitized.hpp"

namespace {

thread_local bool is_slow_to_unlock = false;

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// Here, and not only after it, a thread can be interrupted.
extern "C" int pthread_mutex_unlock(pthread_mutex_t* mutex) {
  using Unlock = int (*)(pthread_mutex_t*);
  static const auto unlock = reinterpret_cast<Unlock>(dlsym(RTLD_NEXT, "pthread_mutex_unlock"));
  const int result = unlock(mutex);
  if (is_slow_to_unlock) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  return result;
}
#endif

namespace collided::server {
namespace {

using test::kIsSanitized;

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

// What posts a job must not touch the worker afterwards: its memory is of no use by then.
TEST(SceneWorker, MayBeGoneBeforeItsLastJobHasBeenPosted) {
  if (kIsSanitized) GTEST_SKIP() << "sanitizers have a pthread_mutex_unlock() of their own";
  alignas(SceneWorker) std::array<std::byte, sizeof(SceneWorker)> memory;
  std::promise<void> gone;
  auto* const target = new (memory.data()) SceneWorker(1);
  std::shared_ptr<SceneWorker> worker(target, [&](SceneWorker* ended) {
    ended->~SceneWorker();
    memory.fill(std::byte{0x55});
    gone.set_value();
  });
  target->wake_early();  // so that the job does not wait for the notification
  is_slow_to_unlock = true;
  target->post([held = std::move(worker)]() mutable { held.reset(); });
  is_slow_to_unlock = false;
  gone.get_future().wait();
}

}  // namespace
}  // namespace collided::server
