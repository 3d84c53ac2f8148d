// Clean-up when collidectl is interrupted. Signal handlers may only make async-signal-safe calls.

#include "client/app/daemon/interrupt.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <tuple>

namespace collided::cli {

namespace {

volatile sig_atomic_t daemon_pid = 0, daemon_input = -1, daemon_output = -1;
volatile sig_atomic_t has_open_line = 0;
std::atomic<void (*)()> restore_terminal = nullptr;
static_assert(std::atomic<void (*)()>::is_always_lock_free);

void stop_all(int signal_number) {
  if (void (*const restore)() = restore_terminal) restore();
  if (has_open_line) std::ignore = write(STDERR_FILENO, "\n", 1);
  if (daemon_pid > 0) {
    std::array<char, 256> last;
    close(daemon_input);
    kill(daemon_pid, SIGKILL);
    while (read(daemon_output, last.data(), last.size()) > 0) {
    }
  }
  _exit(128 + signal_number);
}

std::atomic<int> deferred_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free);

void defer(int signal_number) {
  if (deferred_signal.exchange(signal_number) != 0) stop_all(signal_number);
}

void handle_interrupts(void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal_number, &action, nullptr);
}

}  // namespace

void clean_up_on_interrupt(pid_t daemon, int input, int output) {
  daemon_input = input;
  daemon_output = output;
  daemon_pid = daemon;
  handle_interrupts(stop_all, 0);
}

void no_clean_up_on_interrupt() noexcept { daemon_pid = 0; }

void defer_interrupts() { handle_interrupts(defer, SA_RESTART); }

bool is_interrupted() { return deferred_signal != 0; }

void check_interrupt() {
  if (const int signal_number = deferred_signal) throw Interrupted(signal_number);
}

void restore_on_forced_end(void (*restore)()) { restore_terminal = restore; }

void set_open_line(bool is_open) { has_open_line = is_open; }

}  // namespace collided::cli
