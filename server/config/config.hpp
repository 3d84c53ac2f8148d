#pragma once
// What the daemon is told: flags, then COLLIDED_* in the environment, then a TOML file, then defaults.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::server {

/// What is wrong with an option, or with a file that one names.
class ConfigError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What one client may have at once; tokens can set their own. A quarter of the daemon's, unless told otherwise.
struct ClientLimits {
  uint32_t max_scenes = 16;
  uint64_t max_device_bytes = uint64_t{1} << 30;
  uint32_t max_streams = 64;
  double max_frames_per_second = 20'000;
  double max_frame_seconds = 10;  ///< of a frame's own work, without the wait for its turn
  Accuracy max_accuracy = Accuracy::kExact;

  bool operator==(const ClientLimits&) const = default;
};

/// All finite. What passes them is refused, with the name of the limit. Those that derive_limits() (memory_limits.hpp)
/// finds are here what it finds for a host of 8 GiB.
struct Limits {
  uint64_t max_message_bytes = uint64_t{64} << 20;
  uint64_t max_decode_bytes = uint64_t{256} << 20;  ///< of the messages of all calls, unfolded
  uint64_t max_vertices = 64'000'000;
  uint64_t max_triangles = 128'000'000;
  uint32_t max_scenes = 64;
  uint64_t max_scene_bytes = uint64_t{1} << 30;
  uint64_t max_device_bytes = uint64_t{4} << 30;     ///< of all scenes
  uint64_t max_network_bytes = uint64_t{512} << 20;  ///< of gRPC's buffers, of all connections
  uint32_t max_connections = 0;                      ///< of gRPC; 0: as the limit of file descriptors allows
  uint32_t max_window = 16;
  uint32_t max_streams = 256;
  double max_idle_seconds = 3600;
  double max_silent_seconds = 10;  ///< until a call brings what the daemon waits for
  double lease_seconds = 30;       ///< of scenes that ask for none
  double max_lease_seconds = 3600;
  ClientLimits client;

  bool operator==(const Limits&) const = default;
};

/// PEM files. All empty: plain text.
struct Tls {
  std::string certificate;
  std::string key;
  std::string client_ca;  ///< clients must show a certificate that it signed; empty: they need none

  bool enabled() const { return !certificate.empty(); }
  bool operator==(const Tls&) const = default;
};

struct Config {
  std::vector<std::string> addresses = {"127.0.0.1:50551"};
  std::string endpoint;                ///< told to clients as the address to stream to; empty: none
  std::string http_address;            ///< of metrics and health; empty: off
  std::string local_socket;            ///< path for clients that share memory; empty: off
  std::vector<uint32_t> allowed_uids;  ///< of local_socket, beside the daemon's own user
  bool cuda_ipc = false;               ///< take device memory of clients on the same host
  Tls tls;
  std::string tokens_file;       ///< TOML; empty: no tokens
  bool open_reflection = false;  ///< the services are described to callers without a token, too
  bool allow_insecure = false;   ///< plain text on addresses that others can reach
  std::string backend = "auto";  ///< auto, cpu or cuda
  int threads = 0;               ///< CPU threads of a scene; 0: all cores
  int concurrent_frames = 0;     ///< frames computed at once; 0: as the devices allow
  Limits limits;
  double keepalive_seconds = 10;         ///< between pings to a silent client
  double keepalive_timeout_seconds = 5;  ///< until a client that does not answer them is dropped
  double grace_seconds = 5;              ///< for open streams when the daemon stops
  std::string log_level = "info";
  std::string log_format = "text";  ///< text or json
  std::string ready_file;           ///< gets the bound addresses, a line each; empty: none

  bool operator==(const Config&) const = default;
};

/// The result of reading the command line.
struct ParsedConfig {
  Config config;
  bool run = true;  ///< false: print `text` and exit with `exit_code`
  int exit_code = 0;
  std::string text;
  bool check = false;  ///< only tell whether the configuration is sound
};

/// Flags, then COLLIDED_* in the environment, then the TOML file of --config, then the defaults. Limits that nobody set
/// and that depend on others, or on the host, are 0: for derive_limits().
ParsedConfig parse_config(int argc, const char* const* argv);

/// What SIGHUP brings.
struct Reloaded {
  Config config;                     ///< `current` with what may change while the daemon runs: limits, log, tokens
  std::vector<std::string> restart;  ///< options that were changed, too, but only count after a restart
};

/// Reads everything again. Throws ConfigError if it is not sound.
Reloaded reload_config(int argc, const char* const* argv, const Config& current);

}  // namespace collided::server
