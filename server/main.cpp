// The daemon `collided`: reads its configuration, again at SIGHUP; serves; stops cleanly at SIGTERM or SIGINT, at once
// if asked a second time.
#include <grpc/grpc.h>
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <string.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "server/auth/authenticator.hpp"
#include "server/auth/tls_files.hpp"
#include "server/config/config.hpp"
#include "server/config/rules.hpp"
#include "server/daemon.hpp"
#include "server/net/descriptors.hpp"
#include "server/ops/exit_deadline.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/log.hpp"

namespace {

using collided::server::Config;
using collided::server::ConfigError;
using collided::server::Daemon;
using collided::server::Lifecycle;

constexpr double kSecondsToStop = 5;   // after the grace
constexpr double kGraceOfFailure = 1;  // seconds for the answers that tell of a failed device

struct CommandLine {
  int argc;
  const char* const* argv;
};

// Signals are blocked before any thread exists, so that all threads inherit the mask and only main takes them.
sigset_t block_signals() {
  signal(SIGPIPE, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// gRPC's buffers of a frame, up to 4 MiB each, come and go all the time. Kept, they need not be given back, mapped and
// faulted in anew for each one, which takes longer than to fill them.
void keep_memory() {
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 16 << 20);
  mallopt(M_ARENA_MAX, 4);  // each keeps up to 64 MiB, and there would be eight for each core
}

// Each connection takes a descriptor, and many a system starts its services with no more than 1,024.
void raise_limit() {
  const auto [before, now] = collided::server::raise_descriptor_limit();
  spdlog::info("at most {} file descriptors (soft limit was {})", now, before);
}

// Shutting gRPC down as well can wait 10 s for a poll of its own that nothing wakes: it is left to the process's end.
void keep_grpc() { grpc_init(); }

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

void warn_of_exposure(const Config& config) {
  for (const auto& warning : exposure_warnings(config)) spdlog::warn("{}", warning);
}

// The configuration changes as a whole, or, if anything in it is not sound, not at all.
void reload(const CommandLine& line, Config& config, Daemon& daemon) try {
  auto [next, restart] = collided::server::reload_config(line.argc, line.argv, config);
  daemon.reload(next);
  collided::server::set_up_log(next.log_format, next.log_level);
  config = next;
  spdlog::info("configuration read again");
  for (const auto& name : restart) spdlog::warn("{} has changed, which only counts after a restart", name);
  warn_of_exposure(config);
} catch (const ConfigError& error) {
  spdlog::error("configuration not read again, the one before stays: {}", error.what());
}

// Until a signal asks the daemon to stop, or a failure does: that signal.
int wait_for_end(const CommandLine& line, const sigset_t& signals, Config& config, Daemon& daemon) {
  for (int signal = 0;;) {
    sigwait(&signals, &signal);
    if (signal != SIGHUP) return signal;
    reload(line, config, daemon);
  }
}

bool is_asked_again(const sigset_t& signals) {
  const timespec at_once{};
  const int signal = sigtimedwait(&signals, nullptr, &at_once);
  return signal == SIGTERM || signal == SIGINT;
}

void drain(Daemon& daemon, double grace_seconds, const sigset_t& signals) {
  using std::chrono::steady_clock;
  constexpr auto kStep = std::chrono::milliseconds(20);
  daemon.begin_stop(grace_seconds);
  const auto end = steady_clock::now() +
                   std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(grace_seconds));
  while (steady_clock::now() < end && !daemon.wait_idle(std::min(end, steady_clock::now() + kStep)))
    if (is_asked_again(signals)) {
      spdlog::warn("asked to stop again: ending what is open");
      break;
    }
  daemon.stop();
}

int serve(const CommandLine& line, Config config, const sigset_t& signals) {
  Lifecycle lifecycle([] { kill(getpid(), SIGTERM); });
  raise_limit();
  warn_of_exposure(config);
  keep_grpc();
  Daemon daemon(config, lifecycle);
  for (const auto& address : daemon.addresses()) spdlog::info("collided {} serves on {}", COLLIDED_VERSION, address);
  if (const auto address = daemon.http_address(); !address.empty()) spdlog::info("metrics and health on {}", address);
  write_ready_file(config.ready_file, daemon.addresses());
  const int signal = wait_for_end(line, signals, config, daemon);
  const int code = lifecycle.failed() ? 1 : 0;
  const double grace_seconds = code ? std::min(config.grace_seconds, kGraceOfFailure) : config.grace_seconds;
  const collided::server::ExitDeadline deadline(grace_seconds + kSecondsToStop, code);
  // Not before: whoever takes the log may have stopped to.
  if (code) spdlog::critical("{}", lifecycle.status().text());
  spdlog::info("SIG{}: stopping, at most {} s", sigabbrev_np(signal), grace_seconds);
  drain(daemon, grace_seconds, signals);
  spdlog::info("stopped");
  return code;
}

// What parsing cannot tell: whether the files that options name can be used.
int check(const Config& config) {
  const collided::server::Authenticator authenticator(config);
  collided::server::sound_tls_files(config.tls);
  warn_of_exposure(config);
  std::puts("collided: the configuration is sound");
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const sigset_t signals = block_signals();
  keep_memory();
  const auto parsed = collided::server::parse_config(argc, argv);
  if (!parsed.run) {
    std::fputs(parsed.text.c_str(), parsed.exit_code ? stderr : stdout);
    return parsed.exit_code;
  }
  collided::server::set_up_log(parsed.config.log_format, parsed.config.log_level);
  return parsed.check ? check(parsed.config) : serve({argc, argv}, parsed.config, signals);
} catch (const ConfigError& error) {
  std::fprintf(stderr, "collided: %s\n", error.what());
  return 2;
} catch (const std::exception& error) {
  std::fprintf(stderr, "collided: %s\n", error.what());
  return 1;
}
