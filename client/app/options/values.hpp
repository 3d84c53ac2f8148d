#pragma once
// What options that several subcommands share have chosen. Without the headers of CLI11, which take longer to compile
// than all others.

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "collided/v1/frame.pb.h"
#include "collided/v1/metrics.pb.h"
#include "collided/v1/scene.pb.h"

namespace collided::cli {

/// Which daemon to work with.
struct ServerOptions {
  std::string server;  ///< empty: start one
  std::string backend = "auto";
  std::vector<std::string> part_devices;  ///< ids of the devices of a scene's shards; empty: it is on one
  int threads = 0;
  std::string token_file, tls_ca, tls_certificate, tls_key;  ///< for a running daemon
  std::string daemon_user;  ///< name or id of another user who may listen on the local socket
};

/// What to detect.
struct DetectionOptions {
  std::string mode = "ccd";
  std::string accuracy = "certified";
  double thickness = 0;
  std::vector<std::pair<std::string, double>> half_thicknesses = {};  ///< of meshes, by name, each once
  std::string solids = {};  ///< names of the meshes that are solids, separated by commas; kAllSolids; empty: none
  double delta = 0;
  std::string report = "all";
  std::vector<std::string> kinds{"vt", "ee"};
  std::string engine = "auto";
  std::string reuse = "auto";
  bool advance = false;
  std::string advance_mode = "all-or-one";
  bool limits = false;        ///< of `advance`
  double min_separation = 0;  ///< that `advance` keeps
};

/// Of DetectionOptions::solids: all meshes are.
inline constexpr const char* kAllSolids = "true";
inline bool has_solids(const DetectionOptions& options) { return !options.solids.empty(); }

/// The procedural scene that a subcommand plays.
struct SceneOptions {
  std::string name;
  double scale = 1;
  int frames = 60;
  double t0 = 0;
  double dt = 1.0 / 60;

  /// Time of a frame; a scene ends at 1 and stands still from then on.
  double time(int frame) const { return std::min(1.0, t0 + dt * frame); }
};

/// Throws UsageError for options that contradict each other.
void check_usage(const DetectionOptions& options);

/// Sets whether a frame stops short of its end, and what does.
void set_advance(const DetectionOptions& detection, v1::Frame& frame);

/// Where a scene is to live.
void set_place(const ServerOptions& server, v1::SceneSpec& spec);

/// A spec without meshes.
v1::SceneSpec scene_spec(const ServerOptions& server, const DetectionOptions& detection, v1::PositionFormat format);

/// A number, a word, or several words.
using OptionValue = std::variant<double, std::string, std::vector<std::string>>;
/// The spec's options in the spelling of the command line, each under its name in JSON, in order.
std::vector<std::pair<std::string, OptionValue>> described(const v1::SceneSpec& spec);

/// The words of all formats, such as "f32".
std::vector<std::string> position_formats();
/// `name` is one of position_formats().
v1::PositionFormat format_of(const std::string& name);
constexpr const char* kAutomaticFormat = "auto";
/// The same, or kAutomaticFormat: F64 if a position is not exactly a float, so that nothing is rounded.
v1::PositionFormat choose_format(const std::string& name, bool is_double);

/// The protocol's values in the options' spelling.
std::string name_of(v1::Backend backend);
std::string name_of(v1::PositionFormat format);
std::string name_of(v1::Accuracy accuracy);
std::string name_of(v1::Report report);
std::string name_of(v1::ContactKind kind);
std::string name_of(v1::BroadPhaseEngine engine);
std::string name_of(v1::Reuse reuse);
std::string name_of(v1::ListUse use);

}  // namespace collided::cli
