#pragma once
// Options that several subcommands share.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "collided/v1/scene.pb.h"

namespace collided::cli {

/// Which daemon to work with.
struct ServerOptions {
  std::string server;  ///< empty: start one's own
  std::string backend = "auto";
  int threads = 0;
  std::string token_file, tls_ca, tls_certificate, tls_key;  ///< for a running daemon
  std::string daemon_user;  ///< who may listen at its local socket, by name or id, besides those whom the client trusts
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
};

void add_server_options(CLI::App& command, ServerOptions& options);
void add_detection_options(CLI::App& command, DetectionOptions& options);

/// --engine for several runs, instead of the one of add_detection_options.
void add_engines_option(CLI::App& command, std::vector<std::string>& engines);
/// --position-format, f32 or f64.
void add_position_format_option(CLI::App& command, std::string& format);

/// Throws UsageError for options that cannot go together.
void check_usage(const DetectionOptions& options);

/// A spec without meshes.
v1::SceneSpec scene_spec(const ServerOptions& server, const DetectionOptions& detection, v1::PositionFormat format);

/// Of "f32" or "f64".
v1::PositionFormat format_of(const std::string& name);

/// Lower-case names of the protocol's values, as the options spell them.
std::string name_of(v1::Backend backend);
std::string name_of(v1::PositionFormat format);
std::string name_of(v1::Accuracy accuracy);
std::string name_of(v1::Report report);
std::string name_of(v1::ContactKind kind);
std::string name_of(v1::BroadPhaseEngine engine);

}  // namespace collided::cli
