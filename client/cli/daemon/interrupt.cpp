// Clean-up when collidectl is interrupted. Signal handlers may only make async-signal-safe calls, so the paths are
// prepared in advance.

#include "client/cli/daemon/interrupt.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <tuple>

namespace collided::cli {

namespace {

volatile sig_atomic_t daemon_pid = 0;
volatile sig_atomic_t has_open_line = 0;
std::atomic<void (*)()> restore_terminal = nullptr;
static_assert(std::atomic<void (*)()>::is_always_lock_free);
std::array<char, 128> folder_path, socket_path, ready_path, local_path, log_path;

void stop_all(int signal_number) {
  if (void (*const restore)() = restore_terminal) restore();
  if (has_open_line) std::ignore = write(STDERR_FILENO, "\n", 1);
  if (daemon_pid > 0) {
    kill(daemon_pid, SIGTERM);
    unlink(socket_path.data());
    unlink(ready_path.data());
    unlink(local_path.data());
    unlink(log_path.data());
    rmdir(folder_path.data());
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

void clean_up_on_interrupt(pid_t daemon, const std::string& folder) {
  std::snprintf(folder_path.data(), folder_path.size(), "%s", folder.c_str());
  std::snprintf(socket_path.data(), socket_path.size(), "%s/socket", folder.c_str());
  std::snprintf(ready_path.data(), ready_path.size(), "%s/ready", folder.c_str());
  std::snprintf(local_path.data(), local_path.size(), "%s/local", folder.c_str());
  std::snprintf(log_path.data(), log_path.size(), "%s/log", folder.c_str());
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
