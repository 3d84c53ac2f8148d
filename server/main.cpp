// The daemon `collided`: reads its configuration, and again at SIGHUP; serves; stops cleanly at SIGTERM or SIGINT, at
// once at a second one.
#include <grpc/grpc.h>
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>

#include "deploy/version/version.hpp"
#include "gpu/detector.hpp"
#include "server/auth/authenticator.hpp"
#include "server/auth/tls_files.hpp"
#include "server/config/config.hpp"
#include "server/config/memory_limits.hpp"
#include "server/config/private.hpp"
#include "server/config/reload.hpp"
#include "server/config/rules.hpp"
#include "server/daemon.hpp"
#include "server/devices/chosen_devices.hpp"
#include "server/net/sockets/descriptors.hpp"
#include "server/ops/exit_deadline.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/log.hpp"
#include "server/ops/supervisor/ready_file.hpp"
#include "server/ops/supervisor/supervisor.hpp"
#include "server/private_folder.hpp"
#include "server/start_limits.hpp"
#include "server/start_watch.hpp"
#include "server/usable_memory.hpp"

namespace {

using collided::server::Config;
using collided::server::ConfigError;
using collided::server::Daemon;
using collided::server::Lifecycle;
using collided::server::Memory;
using collided::server::StartWatch;
using collided::server::Supervisor;

constexpr double kSecondsToStop = 5;   // after the grace
constexpr double kSecondsToExit = 1;   // after that
constexpr double kGraceOfFailure = 1;  // seconds to report a failed device
constexpr double kSecondsToCompile = 1800;

/// Sources of the configuration, at the start and at each reload.
struct Origin {
  int argc;
  const char* const* argv;
  Memory memory;
};

// Before any thread exists, so that all threads inherit the mask and only main takes signals: SIGTERM and SIGINT once
// it serves.
sigset_t block_signals() {
  signal(SIGPIPE, SIG_IGN);
  collided::server::exit_on_signals();
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &blocked, nullptr);
  return signals;
}

// gRPC allocates and frees buffers of up to 4 MiB for every frame. Kept in the heap, they are not mapped and faulted in
// each time, which takes longer than filling them.
void keep_memory() {
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 16 << 20);
  mallopt(M_ARENA_MAX, 4);  // each keeps up to 64 MiB; the default is eight per core
}

// Each connection takes a descriptor, and many systems start services with a limit of 1,024.
void raise_limit() {
  const auto [before, now] = collided::server::raise_descriptor_limit();
  spdlog::info("at most {} file descriptors (soft limit was {})", now, before);
}

// gRPC's own shutdown can wait 10 s for a poll that nothing wakes, so it is left to the end of the process.
void keep_grpc() { grpc_init(); }

void check_ready_file(const std::string& path) {
  if (const auto why = collided::server::ready_file_obstacle(path); !why.empty())
    throw ConfigError("ready-file is " + path + ", but " + why);
}

void warn_of_exposure(const Config& config) {
  for (const auto& warning : exposure_warnings(config)) spdlog::warn("{}", warning);
}

// The configuration changes as a whole, or not at all if any part of it is invalid. Returns what is.
std::string reload(const Origin& origin, Config& config, Daemon& daemon) try {
  auto [next, restart] = collided::server::reload_config(origin.argc, origin.argv, config, origin.memory);
  daemon.reload(next);
  collided::server::set_up_log(next.log_format, next.log_level);
  config = next;
  spdlog::info("configuration read again");
  for (const auto& name : restart) spdlog::warn("{} has changed, which takes effect only after a restart", name);
  warn_of_exposure(config);
  return "";
} catch (const ConfigError& error) {
  spdlog::error("configuration not read again, the previous one stays in effect: {}", error.what());
  return error.what();
}

// The next signal; -1 if none comes in time.
int wait_for_signal(const sigset_t& signals, std::chrono::microseconds time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  const timespec wait{seconds.count(), std::chrono::nanoseconds(time - seconds).count()};
  return sigtimedwait(&signals, nullptr, &wait);
}

// Waits until a signal or a failure asks the daemon to stop; returns the signal.
int wait_for_end(const Origin& origin, const sigset_t& signals, Config& config, Daemon& daemon,
                 Supervisor& supervisor) {
  for (;;) {
    const int signal = wait_for_signal(signals, supervisor.alive_interval());
    if (signal == SIGTERM || signal == SIGINT) return signal;
    if (signal == SIGHUP) {
      supervisor.reloading();
      supervisor.reloaded(reload(origin, config, daemon));
    }
    if (supervisor.watches()) daemon.wait_responsive();
    supervisor.alive();
  }
}

bool is_asked_again(const sigset_t& signals) {
  const int signal = wait_for_signal(signals, std::chrono::microseconds(0));
  return signal == SIGTERM || signal == SIGINT;
}

void drain(Daemon& daemon, double grace_seconds, const sigset_t& signals, Supervisor& supervisor) {
  using std::chrono::steady_clock;
  constexpr auto kStep = std::chrono::milliseconds(20);
  daemon.begin_stop(grace_seconds);
  const auto end = steady_clock::now() +
                   std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(grace_seconds));
  while (steady_clock::now() < end && !daemon.wait_idle(std::min(end, steady_clock::now() + kStep))) {
    supervisor.alive();
    if (is_asked_again(signals)) {
      spdlog::warn("asked to stop again: ending what is open");
      break;
    }
  }
  daemon.stop();
}

// Must come before the start, which takes as long. Clients that start a private daemon look for "compiling the kernels"
// in its log, and then wait longer, too.
void announce_compilation(const Config& config, Supervisor& supervisor) {
  for (const auto& info : collided::server::chosen_devices(config)) {
    if (!info.needs_compilation) continue;
    const std::string id = to_string(info.device);
    spdlog::warn(
        "compiling the kernels for {} ({}, compute capability {}), for which this build has only PTX: this takes "
        "minutes unless the driver finds them in its cache (CUDA_CACHE_PATH), where it keeps them",
        id, info.name, info.capability);
    supervisor.starting(kSecondsToCompile, "compiles the kernels for " + id);
  }
  collided::server::flush_log();
}

void print(const std::string& text) {
  if (std::fputs(text.c_str(), stdout) == EOF || std::fflush(stdout) != 0)
    throw std::runtime_error("standard output cannot be written");
}

void set_up_private(Config& config) {
  unsetenv("NOTIFY_SOCKET");  // the service manager is the parent's
  const double seconds_to_stop = config.grace_seconds + kSecondsToStop + kSecondsToExit;
  add_private_sockets(config, collided::server::make_private_folder(seconds_to_stop));
}

// Tells the parent of a private daemon where it serves.
void announce(const std::vector<std::string>& addresses) {
  std::string line;
  for (const auto& address : addresses) line += (line.empty() ? "ready " : ",") + address;
  print(line + "\n");
}

int serve(const Origin& origin, Config config, const sigset_t& signals, std::optional<StartWatch>& watch) {
  check_ready_file(config.ready_file);
  Lifecycle lifecycle([] { kill(getpid(), SIGTERM); });
  Supervisor supervisor;
  raise_limit();
  warn_of_exposure(config);
  spdlog::info("{}", describe_limits(config.limits, origin.memory));
  keep_grpc();
  announce_compilation(config, supervisor);
  Daemon daemon(config, lifecycle);
  for (const auto& address : daemon.addresses()) spdlog::info("collided {} serves on {}", COLLIDED_VERSION, address);
  if (const auto address = daemon.http_address(); !address.empty()) spdlog::info("metrics and health on {}", address);
  collided::server::flush_log();  // whoever waits for the ready file may read the lines above
  watch.reset();                  // whoever is told that it serves may stop it as one that does
  collided::server::write_ready_file(config.ready_file, daemon.addresses());
  if (!config.private_folder.empty()) announce(daemon.addresses());
  supervisor.ready(daemon.addresses());
  const int signal = wait_for_end(origin, signals, config, daemon, supervisor);
  const int code = lifecycle.failed() ? 1 : 0;
  const double grace_seconds = code ? std::min(config.grace_seconds, kGraceOfFailure) : config.grace_seconds;
  const collided::server::ExitDeadline deadline(grace_seconds + kSecondsToStop, code);
  supervisor.stopping(grace_seconds + kSecondsToStop + kSecondsToExit);
  // Only under the deadline: the reader of the log may have stopped.
  if (code) spdlog::critical("{}", lifecycle.status().text());
  spdlog::info("SIG{}: stopping, at most {} s", sigabbrev_np(signal), grace_seconds);
  drain(daemon, grace_seconds, signals, supervisor);
  spdlog::info("stopped");
  return code;
}

// Checks what parsing does not: whether the files that options name are usable.
int check(const Config& config, const Memory& memory) {
  const collided::server::Authenticator authenticator(config);
  collided::server::sound_tls_files(config.tls);
  check_ready_file(config.ready_file);
  warn_of_exposure(config);
  print(describe_limits(config.limits, memory) + "\ncollided: the configuration is valid\n");
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const sigset_t signals = block_signals();
  keep_memory();
  collided::load_kernels_at_start();
  auto [config, run, exit_code, text, is_check, is_private] =
      collided::server::parse_config(argc, argv, collided::version_text("collided"));
  if (!run) {
    if (exit_code == 0)
      print(text);
    else
      std::fputs(text.c_str(), stderr);
    return exit_code;
  }
  if (is_private && !is_check) set_up_private(config);
  if (!is_check) collided::server::check_start_limits(config);
  std::optional<StartWatch> watch(std::in_place);
  collided::server::set_up_log(config.log_format, config.log_level);
  collided::server::flush_log_at_crash();
  const Memory memory = collided::server::usable_memory(config);
  derive_limits(config.limits, memory);
  return is_check ? check(config, memory) : serve({argc, argv, memory}, config, signals, watch);
} catch (const ConfigError& error) {
  collided::server::write_line(std::string("collided: ") + error.what());
  return 2;
} catch (const std::exception& error) {
  collided::server::write_line(std::string("collided: ") + error.what());
  return 1;
}
