#pragma once
// A private daemon (collided --private) that collidectl starts for itself, for as long as the object lives.

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace collided::cli {

struct DaemonOptions {
  std::string backend = "auto";
  int threads = 0;        ///< 0: all cores
  bool tcp = false;       ///< loopback TCP as well
  bool cuda_ipc = false;  ///< and device memory of clients
  uint32_t streams = 0;   ///< limits allow so many scenes, each with a stream on a connection of its own
  bool metrics = false;   ///< served over HTTP
};

class OwnDaemon {
 public:
  /// Finds the program, starts it and waits until it serves. Throws std::runtime_error.
  explicit OwnDaemon(const DaemonOptions& options);
  OwnDaemon(const OwnDaemon&) = delete;
  OwnDaemon& operator=(const OwnDaemon&) = delete;
  /// Ends the daemon, with SIGKILL if that takes long.
  ~OwnDaemon();
  std::string address() const;
  /// host:port if it was asked for, else empty.
  std::string tcp_address() const;
  /// host:port of its metrics, if they were asked for.
  std::string metrics_address() const;

 private:
  void start(std::vector<std::string> words);
  void wait_until_ready(const std::filesystem::path& program);
  std::string why_ended(const std::filesystem::path& program);
  /// Reads what the daemon has said, or says within that time. False once it and its folder are gone.
  bool read_some(std::chrono::milliseconds timeout);
  bool is_gone_within(std::chrono::milliseconds timeout);
  void stop() noexcept;

  pid_t pid_ = -1;           ///< -1 once it has been waited for
  int status_ = 0;           ///< from waitpid
  int input_ = -1;           ///< the daemon ends when this closes
  int output_ = -1;          ///< its log, and its addresses once it is ready
  std::string said_ = "\n";  ///< there, so far
};

/// $COLLIDED_DAEMON, else `collided` next to this program, in ../bin, in the build tree or on PATH.
std::filesystem::path find_daemon();

}  // namespace collided::cli
