// One thread that runs a scene's work in order, with a bounded queue for frames.
#include "server/scenes/scene/worker.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <utility>

#include "server/ops/clock.hpp"

namespace collided::server {

namespace {

// About the time to read a frame of a few MiB; waking an idle processor takes a tenth of it.
constexpr auto kAwake = std::chrono::microseconds(500);

}  // namespace

struct SceneWorker::State {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Job> jobs;
  size_t capacity = 0;
  bool stopping = false;
  Clock::time_point awake_until = Clock::time_point::min();

  bool has_work() const { return stopping || !jobs.empty(); }
};

SceneWorker::SceneWorker(size_t capacity) : state_(std::make_shared<State>()) {
  state_->capacity = capacity;
  thread_ = std::thread([state = state_] { run(state); });
}

// The last job of a deleted scene may hold the scene's last reference, so the destructor can run on the
// worker's own thread, which cannot join itself and ends right afterwards.
SceneWorker::~SceneWorker() {
  {
    std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->changed.notify_all();
  if (thread_.get_id() == std::this_thread::get_id()) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

bool SceneWorker::try_post(Job job) {
  const auto state = state_;  // the job may end the worker before it is told
  {
    std::lock_guard lock(state->mutex);
    if (state->jobs.size() >= state->capacity) return false;
    state->jobs.push_back(std::move(job));
  }
  state->changed.notify_one();
  return true;
}

void SceneWorker::set_capacity(size_t capacity) {
  const std::lock_guard lock(state_->mutex);
  state_->capacity = capacity;
}

void SceneWorker::post(Job job) {
  const auto state = state_;  // the job may end the worker before it is told
  {
    std::lock_guard lock(state->mutex);
    state->jobs.push_back(std::move(job));
  }
  state->changed.notify_one();
}

void SceneWorker::wake_early() {
  const auto state = state_;  // as in post()
  {
    std::lock_guard lock(state->mutex);
    if (state->has_work()) return;
    state->awake_until = Clock::now() + kAwake;
  }
  state->changed.notify_one();
}

void SceneWorker::flush() {
  auto reached = std::make_shared<std::promise<void>>();
  auto future = reached->get_future();
  post([reached] { reached->set_value(); });
  future.wait();
}

// False once the time to poll is over.
bool SceneWorker::poll_awake(State& state, std::unique_lock<std::mutex>& lock) {
  if (Clock::now() >= state.awake_until) return false;
  lock.unlock();
  std::this_thread::yield();
  lock.lock();
  return true;
}

void SceneWorker::run(const std::shared_ptr<State>& state) {
  for (;;) {
    std::unique_lock lock(state->mutex);
    while (!state->has_work())
      if (!poll_awake(*state, lock)) state->changed.wait(lock);
    if (state->jobs.empty()) return;
    Job job = std::move(state->jobs.front());
    state->jobs.pop_front();
    lock.unlock();
    job();
  }
}

}  // namespace collided::server
