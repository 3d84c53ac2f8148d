#pragma once
// What the daemon is told at its start: flags, then COLLIDED_* in the environment, then defaults.

#include <cstdint>
#include <string>
#include <vector>

namespace collided::server {

/// What one client may have at once; tokens can set their own.
struct ClientLimits {
  uint32_t max_scenes = 64;
  uint64_t max_device_bytes = uint64_t{64} << 30;
  uint32_t max_streams = 256;
  double max_frames_per_second = 20'000;
};

/// All finite. What passes them is refused, with the name of the limit.
struct Limits {
  uint64_t max_message_bytes = uint64_t{64} << 20;
  uint64_t max_vertices = 64'000'000;
  uint64_t max_triangles = 128'000'000;
  uint32_t max_scenes = 64;
  uint64_t max_scene_bytes = uint64_t{16} << 30;
  uint64_t max_device_bytes = uint64_t{64} << 30;  ///< of all scenes
  uint32_t max_window = 16;
  uint32_t max_streams = 256;
  double max_idle_seconds = 3600;
  double lease_seconds = 30;  ///< of scenes that ask for none
  double max_lease_seconds = 3600;
  ClientLimits client;
};

struct Config {
  std::vector<std::string> addresses = {"127.0.0.1:50551"};
  std::string backend = "auto";  ///< auto, cpu or cuda
  int threads = 0;               ///< CPU threads of a scene; 0: all cores
  Limits limits;
  double grace_seconds = 5;  ///< for open streams when the daemon stops
  std::string log_level = "info";
  std::string ready_file;  ///< gets the bound addresses, a line each; empty: none
};

/// The result of reading the command line.
struct ParsedConfig {
  Config config;
  bool run = true;  ///< false: print `text` and exit with `exit_code`
  int exit_code = 0;
  std::string text;
};

ParsedConfig parse_config(int argc, const char* const* argv);

/// Empty if the address is host:port or unix:/path, else what is wrong with it.
std::string check_address(const std::string& address);

}  // namespace collided::server
