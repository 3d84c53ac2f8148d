// What the daemon is told at its start.
#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "server/config/config.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxUnixPath = 107;  // sockaddr_un::sun_path without its end

// Options in MiB, as the command line gives them.
struct Megabytes {
  uint64_t message = 0, scene = 0;
};

void add_limits(CLI::App& app, Limits& limits, Megabytes& megabytes) {
  app.add_option("--max-message-mb", megabytes.message, "MiB of one received message")
      ->envname("COLLIDED_MAX_MESSAGE_MB")
      ->check(CLI::Range(1, 2047))
      ->capture_default_str();
  app.add_option("--max-vertices", limits.max_vertices, "Vertices of one scene")
      ->envname("COLLIDED_MAX_VERTICES")
      ->check(CLI::Range(3u, 4294967294u))
      ->capture_default_str();
  app.add_option("--max-triangles", limits.max_triangles, "Triangles of one scene")
      ->envname("COLLIDED_MAX_TRIANGLES")
      ->check(CLI::Range(1u, 1431655764u))
      ->capture_default_str();
  app.add_option("--max-scenes", limits.max_scenes, "Scenes at once")
      ->envname("COLLIDED_MAX_SCENES")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--max-scene-mb", megabytes.scene, "MiB that one scene may hold on its backend")
      ->envname("COLLIDED_MAX_SCENE_MB")
      ->check(CLI::Range(1, 1 << 24))
      ->capture_default_str();
  app.add_option("--max-window", limits.max_window, "Frames in flight on one stream")
      ->envname("COLLIDED_MAX_WINDOW")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

std::string check_number(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? text + " is not a number" : "";
}

void add_options(CLI::App& app, Config& config) {
  app.add_option("--address", config.addresses, "host:port (port 0: any free one) or unix:/path; may be repeated")
      ->envname("COLLIDED_ADDRESS")
      ->delimiter(',')
      ->check(CLI::Validator(check_address, "ADDRESS"))
      ->capture_default_str();
  app.add_option("--backend", config.backend, "Default backend of scenes")
      ->envname("COLLIDED_BACKEND")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  app.add_option("--threads", config.threads, "CPU threads of a scene; 0: all cores")
      ->envname("COLLIDED_THREADS")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_option("--grace-seconds", config.grace_seconds, "Seconds for open streams when the daemon stops")
      ->envname("COLLIDED_GRACE_SECONDS")
      ->check(CLI::Range(0.0, 3600.0))
      ->check(CLI::Validator(check_number, ""))  // Range lets "nan" pass
      ->capture_default_str();
  app.add_option("--log-level", config.log_level, "Least severe messages that are logged")
      ->envname("COLLIDED_LOG_LEVEL")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "critical", "off"}))
      ->capture_default_str();
  app.add_option("--ready-file", config.ready_file, "File that gets the bound addresses once the daemon serves")
      ->envname("COLLIDED_READY_FILE");
}

ParsedConfig stop(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out, err;
  ParsedConfig parsed;
  parsed.run = false;
  parsed.exit_code = app.exit(error, out, err);
  parsed.text = out.str() + err.str();
  return parsed;
}

}  // namespace

std::string check_address(const std::string& address) {
  if (address.starts_with("unix:")) {
    const auto path = address.substr(5);
    if (!path.starts_with('/')) return "\"" + address + "\": a Unix socket needs an absolute path";
    if (path.size() > kMaxUnixPath)
      return "\"" + address + "\": the path has " + std::to_string(path.size()) + " bytes, more than " +
             std::to_string(kMaxUnixPath);
    return {};
  }
  const auto colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0) return "\"" + address + "\" is neither host:port nor unix:/path";
  unsigned port = 0;
  const char* end = address.data() + address.size();
  const auto [parsed, error] = std::from_chars(address.data() + colon + 1, end, port);
  if (error != std::errc() || parsed != end || port > 65535)
    return "\"" + address + "\": the port must be a number from 0 to 65535";
  return {};
}

ParsedConfig parse_config(int argc, const char* const* argv) {
  ParsedConfig parsed;
  Config& config = parsed.config;
  Megabytes megabytes{config.limits.max_message_bytes >> 20, config.limits.max_scene_bytes >> 20};
  CLI::App app("collided: collision detection as a service", "collided");
  app.set_version_flag("--version", std::string("collided " COLLIDED_VERSION));
  app.footer("Every option can come from the environment: --max-scenes is COLLIDED_MAX_SCENES.");
  add_options(app, config);
  add_limits(app, config.limits, megabytes);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return stop(app, error);
  }
  config.limits.max_message_bytes = megabytes.message << 20;
  config.limits.max_scene_bytes = megabytes.scene << 20;
  return parsed;
}

}  // namespace collided::server
