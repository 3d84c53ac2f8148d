// Calls that wait for their client.
#include "server/service/waiting_calls.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "server/errors.hpp"

namespace collided::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPeriod = std::chrono::milliseconds(100);

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

struct WaitingCalls::Wait::State {
  const std::shared_ptr<Shared> shared;
  const WaitRule rule;
  const std::string client;
  const End end;
  const Clock::time_point deadline;
  bool is_over = false;  // guarded by shared->mutex

  bool is_of_same(const State& other) const { return client == other.client && rule.source == other.rule.source; }
};

struct WaitingCalls::Shared {
  using Waiting = std::shared_ptr<Wait::State>;

  std::mutex mutex;
  std::condition_variable changed;
  bool is_stopping = false;
  std::list<Waiting> waits;  // the oldest first

  void take_out_locked(const Waiting& wait) {
    wait->is_over = true;
    waits.remove(wait);
  }

  // The oldest of those that `wait` has to be let in for; null if there is room.
  Waiting oldest_too_many_locked(const Wait::State& wait) const {
    size_t all = 0, own = 0;
    Waiting oldest_own;
    for (const auto& other : waits) {
      if (other->rule.what != wait.rule.what) continue;
      ++all;
      if (other->is_of_same(wait) && !own++) oldest_own = other;
    }
    if (own >= wait.rule.most_of_client) return oldest_own;
    return all >= wait.rule.most ? oldest_of_largest_locked(wait.rule.what) : nullptr;
  }

  Waiting oldest_of_largest_locked(const std::string& what) const {
    std::map<std::pair<std::string_view, std::string_view>, size_t> counts;
    for (const auto& one : waits)
      if (one->rule.what == what) ++counts[{one->client, one->rule.source}];
    Waiting found;
    for (size_t most = 0; const auto& one : waits) {
      if (one->rule.what != what) continue;
      const size_t count = counts[{one->client, one->rule.source}];
      if (count > most) found = one;
      most = std::max(most, count);
    }
    return found;
  }

  std::vector<Waiting> take_late() {
    const std::lock_guard lock(mutex);
    const auto now = Clock::now();
    std::vector<Waiting> late;
    for (const auto& wait : waits)
      if (now >= wait->deadline) late.push_back(wait);
    for (const auto& wait : late) take_out_locked(wait);
    return late;
  }
};

bool WaitingCalls::Wait::over() {
  const std::lock_guard lock(state_->shared->mutex);
  if (state_->is_over) return false;
  state_->shared->take_out_locked(state_);
  return true;
}

WaitingCalls::WaitingCalls() : shared_(std::make_shared<Shared>()), thread_([this] { run(); }) {}

WaitingCalls::~WaitingCalls() {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->is_stopping = true;
  }
  shared_->changed.notify_all();
  thread_.join();
}

std::unique_ptr<WaitingCalls::Wait> WaitingCalls::wait(const WaitRule& rule, const Client& client, End end) {
  std::unique_ptr<Wait> wait(new Wait(
      std::make_shared<Wait::State>(Wait::State{shared_, rule, client->name, std::move(end), after(rule.seconds)})));
  Shared::Waiting pushed_out;
  {
    const std::lock_guard lock(shared_->mutex);
    pushed_out = shared_->oldest_too_many_locked(*wait->state_);
    if (pushed_out) shared_->take_out_locked(pushed_out);
    shared_->waits.push_back(wait->state_);
  }
  if (pushed_out)
    pushed_out->end(std::make_exception_ptr(LimitExceeded::quota(
        "client:" + pushed_out->client,
        fmt::format("{} calls of a client, and {} in all, may wait for {}; more came, and the oldest goes first",
                    rule.most_of_client, rule.most, rule.what))));
  return wait;
}

size_t WaitingCalls::waiting() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->waits.size();
}

void WaitingCalls::run() {
  std::unique_lock lock(shared_->mutex);
  while (!shared_->changed.wait_for(lock, kPeriod, [this] { return shared_->is_stopping; })) {
    lock.unlock();
    for (const auto& wait : shared_->take_late())
      wait->end(std::make_exception_ptr(
          DeadlineExceeded(fmt::format("{} did not come within {} s", wait->rule.what, wait->rule.seconds))));
    lock.lock();
  }
}

}  // namespace collided::server
