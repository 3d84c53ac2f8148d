// A progress line on standard error.

#include "client/cli/progress.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace collided::cli {

namespace {

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Progress::Progress() : is_terminal_(isatty(STDERR_FILENO) != 0), last_seconds_(now_seconds()) {}

Progress::~Progress() {
  if (is_terminal_ && is_shown_) std::fputc('\n', stderr);
}

void Progress::show(const std::string& what, int done, int total) {
  const double now = now_seconds();
  if (now - last_seconds_ < (is_terminal_ ? 0.1 : 1.0)) return;
  last_seconds_ = now;
  is_shown_ = true;
  std::fprintf(stderr, is_terminal_ ? "\r%s: %d of %d " : "%s: %d of %d\n", what.c_str(), done, total);
}

}  // namespace collided::cli
