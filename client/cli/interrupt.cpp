// What an interrupted collidectl still does. A handler may use async-signal-safe calls only: the paths are made before.

#include "client/cli/interrupt.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdio>

namespace collided::cli {

namespace {

volatile sig_atomic_t daemon_pid = 0;
std::array<char, 128> folder_path, socket_path, ready_path;

void stop_all(int signal_number) {
  if (daemon_pid > 0) {
    kill(daemon_pid, SIGTERM);
    unlink(socket_path.data());
    unlink(ready_path.data());
    rmdir(folder_path.data());
  }
  _exit(128 + signal_number);
}

}  // namespace

void clean_up_on_interrupt(pid_t daemon, const std::string& folder) {
  std::snprintf(folder_path.data(), folder_path.size(), "%s", folder.c_str());
  std::snprintf(socket_path.data(), socket_path.size(), "%s/socket", folder.c_str());
  std::snprintf(ready_path.data(), ready_path.size(), "%s/ready", folder.c_str());
  daemon_pid = daemon;
  struct sigaction action {};
  action.sa_handler = stop_all;
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal_number, &action, nullptr);
}

void no_clean_up_on_interrupt() noexcept { daemon_pid = 0; }

}  // namespace collided::cli
