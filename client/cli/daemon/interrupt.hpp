#pragma once
// What an interrupted collidectl (SIGINT, SIGTERM, SIGHUP) still does: stop its daemon and remove its folder, delete
// its scene on a daemon of others, and tell what it has found so far.

#include <sys/types.h>

#include <stdexcept>
#include <string>

namespace collided::cli {

/// Ends collidectl with 128 + the signal's number.
struct Interrupted : std::runtime_error {
  explicit Interrupted(int number)
      : std::runtime_error("interrupted by signal " + std::to_string(number)), signal_number(number) {}
  int signal_number;
};

/// From now on an interrupt ends the daemon and collidectl, and removes the daemon's files in `folder`, and `folder`.
void clean_up_on_interrupt(pid_t daemon, const std::string& folder);
/// The daemon has been stopped: an interrupt has nothing to do any more.
void no_clean_up_on_interrupt() noexcept;

/// From now on the first interrupt is only noted, so that a scene can be deleted and what was found be told; a second
/// one ends collidectl at once.
void note_interrupts();
bool is_interrupted();
/// Throws Interrupted if an interrupt was noted.
void check_interrupt();

/// Whether standard error stands in the middle of a line, which an interrupt then ends.
void set_open_line(bool is_open);

}  // namespace collided::cli
