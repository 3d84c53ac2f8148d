#pragma once
// Where the shards of a scene wait for each other: what they found becomes what the scene found, and a frame counts in
// all of them or in none.

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <span>
#include <stdexcept>
#include <vector>

#include "gpu/base/share.hpp"
#include "gpu/exec/asks.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Another shard has failed, whose error is the frame's.
class ShardFailed : public std::runtime_error {
 public:
  ShardFailed() : std::runtime_error("another part of the scene has failed") {}
};

/// What shards have to know of each other.
struct Found {
  bool any_contact = false;
  double earliest_toi = 1;

  Found joined(const Found& other) const {
    return {any_contact || other.any_contact, std::min(earliest_toi, other.earliest_toi)};
  }
};

/// Of the threads of so many shards, each of which comes to every meeting or fails.
class Meeting {
 public:
  explicit Meeting(size_t shards) : shards_(shards) {}

  /// A frame begins; no shard works on it yet.
  void begin() {
    error_ = nullptr;
    arrived_ = joined_ = 0;
    next_ = {};
  }

  /// Waits for all shards, asking meanwhile whether the frame goes on; what they found together. Throws ShardFailed,
  /// what the question throws.
  Found meet(const Found& mine, Asks& asks) {
    std::unique_lock lock(mutex_);
    if (error_) throw ShardFailed();
    next_ = next_.joined(mine);
    if (++arrived_ == shards_) {
      end_round();
      return all_;
    }
    const uint64_t round = round_;
    while (round_ == round) {
      if (error_) throw ShardFailed();
      all_came_.wait_for(lock, Asks::kUsual);
      if (round_ == round && !error_) ask(lock, round, asks);
    }
    return all_;  // the next round ends with this shard
  }

  /// Makes each value the least of all shards'. All have equally many. Throws as meet().
  void meet_least(std::span<uint64_t> values, Asks& asks) {
    join_least(values);
    meet({}, asks);
    std::ranges::copy(least_, values.begin());
    meet({}, asks);  // the next time begins when all have read this one's
  }

  /// A shard fails with the exception in flight.
  void fail() noexcept {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::current_exception();
    all_came_.notify_all();
  }
  bool has_failed() const {
    const std::lock_guard lock(mutex_);
    return error_ != nullptr;
  }
  /// Of the shard that failed first; null if none did.
  std::exception_ptr error() const {
    const std::lock_guard lock(mutex_);
    return error_;
  }

 private:
  void join_least(std::span<const uint64_t> values) {
    const std::lock_guard lock(mutex_);
    if (joined_ == 0)
      least_.assign(values.begin(), values.end());
    else
      std::ranges::transform(least_, values, least_.begin(), [](uint64_t a, uint64_t b) { return std::min(a, b); });
    joined_ = (joined_ + 1) % shards_;
  }
  void end_round() {
    all_ = next_;
    next_ = {};
    arrived_ = 0;
    ++round_;
    all_came_.notify_all();
  }
  /// Once all have come it is too late to give up: some may go on by now.
  void ask(std::unique_lock<std::mutex>& lock, uint64_t round, Asks& asks) {
    lock.unlock();
    try {
      asks.ask_if_due();
      lock.lock();
    } catch (...) {
      lock.lock();
      if (round_ != round) return;
      if (!error_) error_ = std::current_exception();
      all_came_.notify_all();
      throw;
    }
  }

  const size_t shards_;
  mutable std::mutex mutex_;
  std::condition_variable all_came_;
  size_t arrived_ = 0;
  uint64_t round_ = 0;
  Found next_, all_;
  std::vector<uint64_t> least_;
  size_t joined_ = 0;  ///< shards whose values are in least_, modulo all
  std::exception_ptr error_;
};

/// How a scene that is a shard of another knows of it.
struct ShardOf {
  Meeting& meeting;
  ShareRange share = {};  ///< of the next frame
  /// Takes what the shard answers, before the frame counts. Throws what the frame is refused with.
  std::function<void(FrameResult&, Asks&)> take_answer = {};
};

}  // namespace collided
