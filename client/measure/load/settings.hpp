#pragma once
// What 'collidectl load' is asked for.

#include <optional>
#include <string>
#include <vector>

#include "client/app/options/values.hpp"
#include "client/measure/load/pace/schedule.hpp"

namespace collided::cli::load {

/// What all streams play: a procedural scene, or recorded frames.
struct InputSettings {
  std::string scene;  ///< name; empty: `files`
  double scale = 1;
  int steps = 60;  ///< frames from the scene's beginning to its end
  std::vector<std::string> files;
  std::string position_format = "f32";
};

struct StreamSettings {
  uint32_t clients = 1;
  uint32_t scenes = 1;  ///< of each client, a stream each
  uint32_t window = 2;
  bool latest_wins = false;
  bool shares_connections = false;  ///< one for each client, instead of one for each stream
  uint32_t warm_up = 5;             ///< frames of each stream that are not counted
  uint32_t workers = 0;             ///< 0: by the number of cores
  uint32_t generations = 1;         ///< runs, each on scenes of its own; those of the run before are deleted first
  uint32_t count() const { return clients * scenes; }
};

/// One run: open loop by `profile`, else closed loop for `seconds`.
struct PaceSettings {
  std::optional<RateProfile> profile;  ///< of each stream
  Arrivals arrivals = Arrivals::kFixed;
  uint64_t seed = 1;
  double seconds = 10;
  double drain_seconds = 5;  ///< for frames that are overdue or unanswered at the end
};

/// --find-max: the rates are those of all streams together.
struct FindMaxSettings {
  double p99_ms = 0;  ///< 0: no search
  double from = 0;    ///< where it begins; 0: 10 frames a second of each stream
  double trial_seconds = 5;
  double precision = 0.05;
};

struct LoadSettings {
  ServerOptions server;
  DetectionOptions detection;
  InputSettings input;
  StreamSettings streams;
  PaceSettings pace;
  FindMaxSettings find_max;
  std::string metrics_url;  ///< empty: only its own daemon's
  std::string out, html;    ///< files; empty: none
  bool json = false;
};

/// Whether frames are sent when they are due, whatever became of those before them.
inline bool is_open_loop(const LoadSettings& settings) {
  return settings.pace.profile.has_value() || settings.find_max.p99_ms > 0;
}

}  // namespace collided::cli::load
