#pragma once
// A daemon that collidectl starts for itself, on a Unix socket, for as long as the object lives. No COLLIDED_* variable
// reaches it.

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace collided::cli {

struct DaemonOptions {
  std::string backend = "auto";
  int threads = 0;              ///< 0: all cores
  bool all_transports = false;  ///< loopback TCP and shared memory as well
  bool cuda_ipc = false;        ///< and device memory of clients
  uint32_t streams = 0;         ///< limits allow so many scenes, each with a stream on a connection of its own
  bool metrics = false;         ///< served over HTTP
};

class OwnDaemon {
 public:
  /// Finds the program, starts it and waits until it serves. Throws std::runtime_error.
  explicit OwnDaemon(const DaemonOptions& options);
  OwnDaemon(const OwnDaemon&) = delete;
  OwnDaemon& operator=(const OwnDaemon&) = delete;
  /// Sends SIGTERM, then SIGKILL if the daemon does not end.
  ~OwnDaemon();
  std::string address() const { return "unix:" + (directory_ / "socket").string(); }
  /// host:port if all transports were started, else empty.
  std::string tcp_address() const;
  /// host:port of its metrics, if they were asked for.
  std::string metrics_address() const;

 private:
  void start(const std::filesystem::path& program, const DaemonOptions& options);
  void wait_until_ready(const std::filesystem::path& program);
  bool has_ended();
  void stop() noexcept;

  std::filesystem::path directory_;
  pid_t pid_ = -1;
  int status_ = 0;  ///< from waitpid, once the daemon has ended
};

/// $COLLIDED_DAEMON, else `collided` next to this program, in ../bin, in the build tree or on PATH.
std::filesystem::path find_daemon();

}  // namespace collided::cli
