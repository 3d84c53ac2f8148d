#pragma once
// A progress line on standard error: rewritten in place on a terminal, else a line every second.

#include <chrono>
#include <string>

namespace collided::cli {

class Progress {
 public:
  Progress();
  /// Shows "what: done of total", unless the last line is too recent.
  void show(const std::string& what, int done, int total);
  ~Progress();

 private:
  using Clock = std::chrono::steady_clock;

  bool is_terminal_;
  bool is_shown_ = false;
  Clock::time_point last_;
};

}  // namespace collided::cli
