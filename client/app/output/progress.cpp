// A progress line on standard error.

#include "client/app/output/progress.hpp"

#include <unistd.h>

#include <cstdio>

#include "client/app/daemon/interrupt.hpp"

namespace collided::cli {

Progress::Progress() : is_terminal_(isatty(STDERR_FILENO) != 0), last_(Clock::now()) {}

Progress::~Progress() {
  if (!is_terminal_ || !is_shown_) return;
  std::fputc('\n', stderr);
  set_open_line(false);
}

void Progress::show(const std::string& what, int done, int total) {
  constexpr std::chrono::milliseconds kTerminalInterval(100), kLineInterval(1000);
  const auto now = Clock::now();
  if (now - last_ < (is_terminal_ ? kTerminalInterval : kLineInterval)) return;
  last_ = now;
  is_shown_ = true;
  set_open_line(is_terminal_);
  std::fprintf(stderr, is_terminal_ ? "\r%s: %d of %d " : "%s: %d of %d\n", what.c_str(), done, total);
}

}  // namespace collided::cli
