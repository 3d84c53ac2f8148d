// Calls that wait for their client.
#include "server/limits/waiting_calls.hpp"

#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <list>
#include <map>
#include <utility>

#include "server/errors.hpp"

namespace collided::server {
namespace {

using Clock = std::chrono::steady_clock;
using Source = std::pair<std::string, std::string>;  // a client's name, and what tells clients of the same name apart

constexpr auto kPeriod = std::chrono::milliseconds(100);

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// The exception that `make` makes, or that memory was short for it.
template <class Make>
std::exception_ptr exception_of(const Make& make) {
  try {
    return std::make_exception_ptr(make());
  } catch (...) {
    return std::current_exception();
  }
}

std::exception_ptr eviction(const WaitRule& rule, const std::string& client) {
  return exception_of([&] {
    return LimitExceeded::quota(
        "client:" + client,
        fmt::format("{} calls of a client, and {} in all, may wait for {}; more arrived, and the oldest is ended first",
                    rule.max_of_client, rule.max, rule.what));
  });
}

std::exception_ptr lateness(const WaitRule& rule) {
  return exception_of(
      [&] { return DeadlineExceeded(fmt::format("{} did not come within {} s", rule.what, rule.seconds)); });
}

}  // namespace

struct WaitingCalls::Wait::State {
  const std::shared_ptr<Shared> shared;
  const WaitRule rule;
  const Source source;
  const End end;
  const Clock::time_point deadline;
  // Guarded by shared->mutex:
  bool is_finished = true;                                 // until it waits
  uint64_t number = 0;                                     // the lower, the older
  std::list<std::shared_ptr<State>>::iterator place = {};  // until it is finished
};

struct WaitingCalls::Shared {
  using Waiting = std::shared_ptr<Wait::State>;
  using Waits = std::list<Waiting>;  // the oldest first

  // The calls that wait for the same thing.
  struct Line {
    std::map<Source, Waits> of_source;  // none is empty
    size_t size = 0;

    // The call to evict for `wait`; null if there is room.
    Waiting oldest_to_evict(const Wait::State& wait) const {
      const auto own = of_source.find(wait.source);
      const size_t count = own == of_source.end() ? 0 : own->second.size();
      if (count > 0 && count >= wait.rule.max_of_client) return own->second.front();
      return size >= wait.rule.max ? oldest_of_largest() : nullptr;
    }

    Waiting oldest_of_largest() const {
      const Waits* found = nullptr;
      for (const auto& [source, waits] : of_source)
        if (!found || waits.size() > found->size() ||
            (waits.size() == found->size() && waits.front()->number < found->front()->number))
          found = &waits;
      return found ? found->front() : nullptr;
    }
  };

  std::mutex mutex;
  std::condition_variable changed;
  bool is_stopping = false;
  uint64_t next_number = 0;
  std::map<std::string, Line> lines;  // by what is awaited; none is empty

  // If this throws, as memory is short, nothing has changed.
  void put_in_locked(const Waiting& wait) {
    Waits one{wait};
    const auto line = lines.try_emplace(wait->rule.what).first;
    Waits* waits = nullptr;
    try {
      waits = &line->second.of_source[wait->source];
    } catch (...) {
      if (line->second.size == 0) lines.erase(line);
      throw;
    }
    wait->number = next_number++;
    wait->place = one.begin();
    wait->is_finished = false;
    waits->splice(waits->end(), one);
    ++line->second.size;
  }

  void take_out_locked(const Waiting& wait) {
    wait->is_finished = true;
    const auto line = lines.find(wait->rule.what);
    const auto waits = line->second.of_source.find(wait->source);
    waits->second.erase(wait->place);
    if (waits->second.empty()) line->second.of_source.erase(waits);
    if (--line->second.size == 0) lines.erase(line);
  }

  Waiting oldest_to_evict_locked(const Wait::State& wait) const {
    const auto line = lines.find(wait.rule.what);
    return line == lines.end() ? nullptr : line->second.oldest_to_evict(wait);
  }

  Waits take_late() {
    const std::lock_guard lock(mutex);
    const auto now = Clock::now();
    Waits late;
    for (auto& [what, line] : lines) {
      for (auto& [source, waits] : line.of_source)
        for (auto wait = waits.begin(); wait != waits.end();) {
          const auto next = std::next(wait);
          if (now >= (*wait)->deadline) {
            (*wait)->is_finished = true;
            late.splice(late.end(), waits, wait);
            --line.size;
          }
          wait = next;
        }
      std::erase_if(line.of_source, [](const auto& of) { return of.second.empty(); });
    }
    std::erase_if(lines, [](const auto& line) { return line.second.size == 0; });
    return late;
  }
};

bool WaitingCalls::Wait::finish() {
  const std::lock_guard lock(state_->shared->mutex);
  if (state_->is_finished) return false;
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
  std::unique_ptr<Wait> wait(new Wait(std::make_shared<Wait::State>(
      Wait::State{shared_, rule, {client->name, rule.source}, std::move(end), after(rule.seconds)})));
  Shared::Waiting evicted;
  {
    const std::lock_guard lock(shared_->mutex);
    evicted = shared_->oldest_to_evict_locked(*wait->state_);
    shared_->put_in_locked(wait->state_);
    if (evicted) shared_->take_out_locked(evicted);
  }
  if (evicted) evicted->end(eviction(rule, evicted->source.first));
  return wait;
}

size_t WaitingCalls::waiting() const {
  const std::lock_guard lock(shared_->mutex);
  size_t count = 0;
  for (const auto& [what, line] : shared_->lines) count += line.size;
  return count;
}

void WaitingCalls::run() {
  std::unique_lock lock(shared_->mutex);
  while (!shared_->changed.wait_for(lock, kPeriod, [this] { return shared_->is_stopping; })) {
    lock.unlock();
    for (const auto& wait : shared_->take_late()) wait->end(lateness(wait->rule));
    lock.lock();
  }
}

}  // namespace collided::server
