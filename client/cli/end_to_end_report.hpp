#pragma once
// What 'collidectl bench --end-to-end' found, as JSON and as a table.

#include <string>
#include <vector>

#include "client/cli/report.hpp"

namespace collided::cli {

/// One frame over one transport; times in milliseconds.
struct FrameTime {
  double latency = 0;  ///< from send to the complete answer
  double engine = 0;   ///< of it, the daemon's engine
  double decode = 0, encode = 0, queue = 0;
};

/// The frames of one transport, in their order; 1 or more.
struct WayTimes {
  std::string name;
  std::vector<FrameTime> frames;
};

/// One size of one scene.
struct EndToEndRun {
  std::string name;
  double scale = 1;
  v1::Scene scene;
  std::vector<WayTimes> ways;
  std::vector<double> bare_tcp, bare_unix;                   ///< milliseconds, a value for each frame
  std::vector<double> bytes_up, bytes_down;                  ///< of positions and of contacts, a value for each frame
  std::vector<std::pair<std::string, std::string>> skipped;  ///< transports without one, and why
};

/// The engine's time as the daemon tells it; for one that does not, the sum of the stages.
FrameTime frame_time(double latency, const v1::FrameMetrics& metrics);

/// Overhead is a frame's latency without the engine's time, and its ratio that of medians.
Json end_to_end_json(const EndToEndRun& run);
/// The whole file: {"device", "settings", "runs"}.
Json end_to_end_file(const std::vector<EndToEndRun>& runs, int warm_up);
/// A table of what end_to_end_json gave.
std::string end_to_end_lines(const Json& run);

}  // namespace collided::cli
