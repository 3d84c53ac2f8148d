#pragma once
// A decision about numbers whose exponents lie far apart takes long: now and then it lets its thread look up.

#include <functional>
#include <utility>

namespace collided::exact {

/// While it lives, decisions of its thread call `poll` every millisecond or so; what that throws ends the decision.
class PollScope {
 public:
  explicit PollScope(std::function<void()> poll) : poll_(std::move(poll)) { current_ = this; }
  PollScope(const PollScope&) = delete;
  PollScope& operator=(const PollScope&) = delete;
  ~PollScope() { current_ = nullptr; }

  /// A step of a decision: some operations on integers of its size.
  static void step() {
    if (current_ != nullptr && ++current_->steps_ % kSteps == 0) current_->poll_();
  }

 private:
  static constexpr unsigned kSteps = 16;  // a look at the clock takes as long as a step with small integers
  inline static thread_local PollScope* current_ = nullptr;

  const std::function<void()> poll_;
  unsigned steps_ = 0;
};

}  // namespace collided::exact
