#pragma once
// The daemon's configuration: from flags, else COLLIDED_* in the environment, else a TOML file, else defaults.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/config/file/config_error.hpp"
#include "server/config/limits.hpp"

namespace collided::server {

/// Seconds between the pings of a gRPC client, at least, while it gets no answers. A client that looks whether the
/// daemon still lives needs none more often than once a second.
constexpr double kMinPingSeconds = 0.1;

/// Calls that one connection may have at once, from the start of the daemon on; further ones wait until some have
/// ended. All streams of a client, and its other calls, may share one connection.
inline uint32_t max_calls_of_connection(const Limits& limits) {
  constexpr uint32_t kMin = 256, kMax = 1'000'000;
  return std::clamp(2 * limits.max_streams, kMin, kMax);
}

/// PEM files. All empty: plain text.
struct Tls {
  std::string certificate;
  std::string key;
  std::string client_ca;  ///< signs the certificates that clients must present; empty: none required

  bool enabled() const { return !certificate.empty(); }
  bool operator==(const Tls&) const = default;
};

struct Config {
  std::vector<std::string> addresses = {"127.0.0.1:50551"};
  std::string name;                    ///< begins the ids of its scenes; empty: nothing does
  std::string endpoint;                ///< address advertised to clients for streaming; empty: none
  std::string http_address;            ///< metrics and health; empty: off
  std::string local_socket;            ///< path of the shared-memory socket; empty: off
  std::vector<uint32_t> allowed_uids;  ///< of local_socket, besides the daemon's own
  bool cuda_ipc = false;               ///< accept device memory of clients on the same host
  Tls tls;
  std::string tokens_file;       ///< TOML; empty: no tokens
  bool open_reflection = false;  ///< serve reflection to callers without a token, too
  bool allow_insecure = false;   ///< allow plain text on addresses that other hosts can reach
  std::string backend = "auto";  ///< auto, cpu or cuda
  /// Ids of those that scenes can live on, such as "cuda:1"; empty: every CUDA device and the CPU.
  std::vector<std::string> devices;
  int threads = 0;            ///< CPU threads of a scene; 0: all cores, of which each device of the CPU has its share
  int concurrent_frames = 0;  ///< frames computed at once on a device; 0: 4 to 12 on a GPU, else 2
  Limits limits;
  double keepalive_seconds = 10;         ///< between pings to a silent client
  double keepalive_timeout_seconds = 5;  ///< until a client that does not answer a ping is dropped
  double grace_seconds = 5;              ///< for open streams when the daemon stops
  std::string log_level = "info";
  std::string log_format = "text";  ///< text or json
  bool gives_back_memory = true;    ///< that was freed, to the system: not in a process of others; no option
  std::string ready_file;           ///< receives the bound addresses, one per line; empty: none
  std::string private_folder;       ///< holds the sockets of a private daemon; empty: it is none; no option

  bool operator==(const Config&) const = default;
};

/// The result of reading the command line.
struct ParsedConfig {
  Config config;
  bool run = true;  ///< false: print `text` and exit with `exit_code`
  int exit_code = 0;
  std::string text;
  bool check = false;       ///< only check the configuration
  bool is_private = false;  ///< its sockets are still to be added
};

/// Flags, else COLLIDED_* in the environment, else the TOML file of --config, else defaults. Unset limits that depend
/// on others or on the host are 0, for derive_limits(). --version prints `version`.
ParsedConfig parse_config(int argc, const char* const* argv, const std::string& version = "collided " COLLIDED_VERSION);

}  // namespace collided::server
