#pragma once
// What the daemon is told at its start: flags, then COLLIDED_* in the environment, then defaults.

#include <cstdint>
#include <string>
#include <vector>

namespace collided::server {

struct Limits {
  uint64_t max_message_bytes = uint64_t{64} << 20;
  uint64_t max_vertices = 64'000'000;
  uint64_t max_triangles = 128'000'000;
  uint32_t max_scenes = 64;
  uint64_t max_scene_bytes = uint64_t{16} << 30;
  uint32_t max_window = 16;
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
