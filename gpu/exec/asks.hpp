#pragma once
// When the thread that a frame belongs to asks whether the frame goes on. All others that work on it come to rest
// before (exec/cpu/cpu_loops.hpp): the answer may take its time, and then nothing of the frame goes on meanwhile.

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <utility>

#include "gpu/types.hpp"

namespace collided {

/// Work on a frame took longer than was allowed (Asks::allow).
struct OutOfTime {};

class Asks {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kUsual{8};

  /// A frame begins, whose question this is; may be empty. `between`: work until it is asked again; with 0 it is asked
  /// whenever that can be.
  void begin(std::function<bool()> cancelled, Clock::duration between = kUsual) {
    cancelled_ = std::move(cancelled);
    between_ = between;
    waited_ = {};
    allow_any();
  }
  /// From here on the frame's work may take so long, without what it spends in its question; then it is thrown.
  void allow(Clock::duration work) {
    latest_ = Clock::now() + work - waited_;
    set_due();
  }
  void allow_any() {
    latest_.reset();
    set_due();
  }

  /// From any thread that works on the frame: whether it is time to come to rest.
  bool is_due() const {
    const Clock::rep due = due_.load(std::memory_order_relaxed);
    return due != kNever && Clock::now().time_since_epoch().count() >= due;
  }

  /// Throws Cancelled, OutOfTime, or what the question throws.
  void ask() {
    if (!asks()) return;
    const auto start = Clock::now();
    if (latest_ && start > *latest_ + waited_) throw OutOfTime();
    const bool over = cancelled_ && cancelled_();
    waited_ += Clock::now() - start;
    if (over) throw Cancelled();
    set_due();
  }
  void ask_if_due() {
    if (is_due()) ask();
  }
  /// From here to the end of the frame: what is left to do has to be done as a whole.
  void no_more() { begin({}); }

  /// What the frame has spent in its question.
  Clock::duration waited() const { return waited_; }

 private:
  static constexpr Clock::rep kNever = Clock::duration::max().count();
  bool asks() const { return cancelled_ || latest_; }
  void set_due() { due_ = asks() ? (Clock::now() + between_).time_since_epoch().count() : kNever; }

  std::function<bool()> cancelled_;
  Clock::duration between_ = kUsual;
  std::atomic<Clock::rep> due_ = kNever;  ///< on the clock
  Clock::duration waited_{};
  std::optional<Clock::time_point> latest_;  ///< at which the work has to be done, had it never waited
};

/// As long as this lives, the frame's work may take so many milliseconds; 0: any number.
class AllowedWork {
 public:
  AllowedWork(Asks& asks, double milliseconds) : asks_(asks) {
    if (milliseconds > 0)
      asks_.allow(std::chrono::duration_cast<Asks::Clock::duration>(std::chrono::duration<double, std::milli>(milliseconds)));
  }
  ~AllowedWork() { asks_.allow_any(); }
  AllowedWork(const AllowedWork&) = delete;
  AllowedWork& operator=(const AllowedWork&) = delete;

 private:
  Asks& asks_;
};

/// Time that the frame has worked since this was made, without what it spent in its question.
class WorkTime {
 public:
  explicit WorkTime(const Asks& asks) : asks_(asks), waited_(asks.waited()) {}
  double milliseconds() const {
    const auto worked = Asks::Clock::now() - start_ - (asks_.waited() - waited_);
    return std::chrono::duration<double, std::milli>(worked).count();
  }

 private:
  const Asks& asks_;
  const Asks::Clock::time_point start_ = Asks::Clock::now();
  const Asks::Clock::duration waited_;
};

}  // namespace collided
