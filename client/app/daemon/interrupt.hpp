#pragma once
// Clean-up when collidectl is interrupted (SIGINT, SIGTERM, SIGHUP): it stops its daemon, deletes its scene on a
// foreign daemon, and reports what it has found so far.

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

/// From now on an interrupt ends the daemon and collidectl. The daemon ends when its `input` closes. Its `output`
/// closes once the daemon and its files are gone.
void clean_up_on_interrupt(pid_t daemon, int input, int output);
/// The daemon has been stopped: there is nothing left to clean up.
void no_clean_up_on_interrupt() noexcept;

/// From now on the first interrupt only sets is_interrupted() and makes check_interrupt() throw, so that the scene can
/// be deleted and the results so far reported; a second one ends collidectl at once.
void defer_interrupts();
bool is_interrupted();
/// Throws Interrupted after an interrupt.
void check_interrupt();

/// Calls `restore`, which may only make async-signal-safe calls, before an interrupt ends collidectl at once; nullptr:
/// nothing.
void restore_on_forced_end(void (*restore)());

/// Whether standard error is in the middle of a line, which an interrupt then ends.
void set_open_line(bool is_open);

}  // namespace collided::cli
