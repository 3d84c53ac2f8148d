// The daemon `collided`: reads its configuration, serves, and stops cleanly on SIGTERM or SIGINT.
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "server/config/config.hpp"
#include "server/daemon.hpp"

namespace {

using collided::server::Config;
using collided::server::Daemon;

// Signals are blocked before any thread exists, so that all threads inherit the mask and only main takes them.
sigset_t block_signals() {
  signal(SIGPIPE, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Frames of some MiB come and go all the time: keep their memory instead of mapping and faulting it anew each time.
void keep_large_blocks() {
  mallopt(M_MMAP_THRESHOLD, 64 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

// Renamed into place, so that whoever waits for the file never reads half of it.
void write_ready_file(const std::string& path, const std::vector<std::string>& addresses) {
  if (path.empty()) return;
  const std::string part = path + ".part";
  std::ofstream file(part);
  for (const auto& address : addresses) file << address << '\n';
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(part, path, error);
  if (!file || error) throw std::runtime_error("cannot write the ready file " + path);
}

void serve(const Config& config, const sigset_t& signals) {
  Daemon daemon(config);
  for (const auto& address : daemon.addresses()) spdlog::info("collided {} serves on {}", COLLIDED_VERSION, address);
  write_ready_file(config.ready_file, daemon.addresses());
  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("signal {}: stopping, at most {} s", signal, config.grace_seconds);
  daemon.stop(config.grace_seconds);
  spdlog::info("stopped");
}

}  // namespace

int main(int argc, char** argv) try {
  const sigset_t signals = block_signals();
  keep_large_blocks();
  const auto parsed = collided::server::parse_config(argc, argv);
  if (!parsed.run) {
    std::fputs(parsed.text.c_str(), parsed.exit_code ? stderr : stdout);
    return parsed.exit_code;
  }
  spdlog::set_level(spdlog::level::from_str(parsed.config.log_level));
  serve(parsed.config, signals);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "collided: %s\n", error.what());
  return 1;
}
