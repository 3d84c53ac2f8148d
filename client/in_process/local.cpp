// The engine in this process.
#include "client/in_process/local.hpp"

#include <pthread.h>
#include <signal.h>

#include <memory>
#include <utility>

#include "client/cpp/transport/grpc/channel.hpp"
#include "client/in_process/daemon.hpp"
#include "client/in_process/failure.hpp"

namespace collided {

namespace {

/// Threads inherit the mask of the one that starts them. Signals of faults stay with the thread that causes them.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT}) sigdelset(&all, fault);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_;
};

LogLevel level_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::trace:
    case spdlog::level::debug:
      return LogLevel::kDebug;
    case spdlog::level::info:
      return LogLevel::kInfo;
    case spdlog::level::warn:
      return LogLevel::kWarning;
    default:
      return LogLevel::kError;
  }
}

spdlog::level::level_enum level_of(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      break;
  }
  return spdlog::level::err;
}

}  // namespace

client::Client local(const LocalEngine& engine, const client::ConnectOptions& options) {
  const BlockedSignals blocked;
  const auto daemon = client::as_errors([&] {
    return std::make_shared<client::DaemonHere>(
        server::InProcessOptions{engine.backend, engine.threads, engine.concurrent_frames, engine.memory_bytes});
  });
  return client::Client::connect(client::ChannelFactory(daemon, options));
}

void set_local_log(LogLevel level, std::function<void(LogLevel level, const std::string& line)> take) {
  if (!take) return server::send_log_to(spdlog::level::off, nullptr);
  server::send_log_to(level_of(level), [take = std::move(take)](spdlog::level::level_enum of, const std::string& line) {
    take(level_of(of), line);
  });
}

}  // namespace collided
