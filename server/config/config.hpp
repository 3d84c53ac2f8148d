#pragma once
// The daemon's configuration: from flags, else COLLIDED_* in the environment, else a TOML file, else defaults.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::server {

/// An option is wrong, or a file that an option names.
class ConfigError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What one client may have at once; a token can have its own. By default a quarter of what all clients may have.
struct ClientLimits {
  uint32_t max_scenes = 16;
  uint64_t max_device_bytes = uint64_t{1} << 30;
  uint32_t max_streams = 64;
  double max_frames_per_second = 20'000;
  double max_frame_seconds = 10;  ///< of work on a frame, without the wait for its turn
  Accuracy max_accuracy = Accuracy::kExact;

  bool operator==(const ClientLimits&) const = default;
};

/// All finite. What exceeds them is refused with the name of the limit. The defaults of those that derive_limits()
/// (memory_limits.hpp) sets are what it sets for a host of 8 GiB.
struct Limits {
  uint64_t max_message_bytes = uint64_t{64} << 20;
  uint64_t max_decode_bytes = uint64_t{256} << 20;  ///< of the messages of all calls, in memory
  uint64_t max_vertices = 64'000'000;
  uint64_t max_triangles = 128'000'000;
  uint32_t max_scenes = 64;
  uint64_t max_scene_bytes = uint64_t{1} << 30;
  uint64_t max_device_bytes = uint64_t{4} << 30;     ///< of all scenes
  uint64_t max_network_bytes = uint64_t{512} << 20;  ///< of gRPC's buffers for all connections
  uint32_t max_connections = 0;                      ///< of gRPC; 0: as the limit of file descriptors allows
  uint32_t max_window = 16;
  uint32_t max_streams = 256;
  double max_idle_seconds = 3600;
  double max_silent_seconds = 10;  ///< to wait for a call's opening, message or next chunk
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
  std::string endpoint;                ///< address that clients are told to stream to; empty: none
  std::string http_address;            ///< of metrics and health; empty: off
  std::string local_socket;            ///< path of the socket for clients that share memory; empty: off
  std::vector<uint32_t> allowed_uids;  ///< of local_socket, besides the daemon's own user
  bool cuda_ipc = false;               ///< accept device memory of clients on the same host
  Tls tls;
  std::string tokens_file;       ///< TOML; empty: no tokens
  bool open_reflection = false;  ///< describe the services to callers without a token, too
  bool allow_insecure = false;   ///< allow plain text on addresses that other hosts can reach
  std::string backend = "auto";  ///< auto, cpu or cuda
  int threads = 0;               ///< CPU threads of a scene; 0: all cores
  int concurrent_frames = 0;     ///< frames computed at once; 0: as the devices allow
  Limits limits;
  double keepalive_seconds = 10;         ///< between pings to a silent client
  double keepalive_timeout_seconds = 5;  ///< until a client that does not answer them is dropped
  double grace_seconds = 5;              ///< for open streams when the daemon stops
  std::string log_level = "info";
  std::string log_format = "text";  ///< text or json
  std::string ready_file;           ///< file that the bound addresses are written to, a line each; empty: none

  bool operator==(const Config&) const = default;
};

/// The result of reading the command line.
struct ParsedConfig {
  Config config;
  bool run = true;  ///< false: print `text` and exit with `exit_code`
  int exit_code = 0;
  std::string text;
  bool check = false;  ///< only check the configuration
};

/// Flags, else COLLIDED_* in the environment, else the TOML file of --config, else defaults. Limits that nobody has set
/// and that depend on others or on the host are 0, for derive_limits().
ParsedConfig parse_config(int argc, const char* const* argv);

/// The result of SIGHUP.
struct Reloaded {
  Config config;                     ///< `current` with the changes that need no restart: limits, log, tokens
  std::vector<std::string> restart;  ///< other changed options, which only count after a restart
};

/// Reads the configuration again. Throws ConfigError if it is not sound.
Reloaded reload_config(int argc, const char* const* argv, const Config& current);

}  // namespace collided::server
