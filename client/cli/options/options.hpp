#pragma once
// Options that several subcommands share.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "collided/v1/scene.pb.h"

namespace collided::cli {

/// Which daemon to work with.
struct ServerOptions {
  std::string server;  ///< empty: start one
  std::string backend = "auto";
  int threads = 0;
  std::string token_file, tls_ca, tls_certificate, tls_key;  ///< for a running daemon
  std::string daemon_user;  ///< name or id of another user who may listen on the local socket
};

/// What to detect.
struct DetectionOptions {
  std::string mode = "ccd";
  std::string accuracy = "certified";
  double thickness = 0;
  double delta = 0;
  std::string report = "all";
  std::vector<std::string> kinds{"vt", "ee"};
  std::string engine = "auto";
  bool advance = false;
  double min_separation = 0;  ///< that `advance` keeps
};

void add_server_options(CLI::App& command, ServerOptions& options);
void add_detection_options(CLI::App& command, DetectionOptions& options);
/// For subcommands that play a motion and can stop short of its end.
void add_advance_options(CLI::App& command, DetectionOptions& options);

/// Replaces --engine of add_detection_options with one that takes several engines.
void add_engines_option(CLI::App& command, std::vector<std::string>& engines);
/// --position-format, one of f32, f64 and q16.
void add_position_format_option(CLI::App& command, std::string& format);

/// The same, or kAutomaticFormat, for subcommands that read mesh files.
void add_automatic_format_option(CLI::App& command, std::string& format);
constexpr const char* kAutomaticFormat = "auto";

/// Throws UsageError for options that contradict each other.
void check_usage(const DetectionOptions& options);

/// Where a scene is to live.
v1::Backend backend_of(const ServerOptions& server);

/// A spec without meshes.
v1::SceneSpec scene_spec(const ServerOptions& server, const DetectionOptions& detection, v1::PositionFormat format);

/// `name` is one of "f32", "f64", "q16".
v1::PositionFormat format_of(const std::string& name);
/// The same, or kAutomaticFormat: F64 if a position is not exactly a float, so that nothing is rounded.
v1::PositionFormat choose_format(const std::string& name, bool is_double);

/// The protocol's values in the options' spelling.
std::string name_of(v1::Backend backend);
std::string name_of(v1::PositionFormat format);
std::string name_of(v1::Accuracy accuracy);
std::string name_of(v1::Report report);
std::string name_of(v1::ContactKind kind);
std::string name_of(v1::BroadPhaseEngine engine);

}  // namespace collided::cli
