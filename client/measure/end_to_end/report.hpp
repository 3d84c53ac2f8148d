#pragma once
// What 'collidectl bench --end-to-end' found, as JSON and as a table.

#include <string>
#include <vector>

#include "client/cli/report/json.hpp"

namespace collided::cli {

/// One frame over one transport; times in milliseconds.
struct FrameTime {
  double latency = 0;  ///< from send to the complete answer
  double engine = 0;   ///< of it, the daemon's engine
  double decode = 0, encode = 0, queue = 0;
};

/// The frames of one transport, in their order; 1 or more.
struct TransportTimes {
  std::string name;
  std::vector<FrameTime> frames;
};

/// A frame's bytes over bare sockets; milliseconds, a value for each frame.
struct BareTimes {
  std::vector<double> tcp, unix_stream;
};

/// A control message's, as shared memory needs one each way.
constexpr size_t kFewBytes = 64;

/// One size of one scene.
struct EndToEndRun {
  std::string name;
  double scale = 1;
  v1::Scene scene;
  std::vector<TransportTimes> transports;
  BareTimes bare;                            ///< of sockets that answer at once
  BareTimes held;                            ///< of sockets that answer after the engine's time, as a frame is answered
  std::vector<double> held_few;              ///< the same for kFewBytes to and fro over the Unix socket
  std::vector<double> bytes_up, bytes_down;  ///< of positions and of contacts, a value for each frame
};

/// The engine's time as the daemon tells it; for one that does not, the sum of the stages.
FrameTime frame_time(double latency, const v1::FrameMetrics& metrics);

/// Overhead is a frame's latency without the engine's time, and its ratios those of medians.
Json end_to_end_json(const EndToEndRun& run);
/// The whole file: {"device", "settings", "runs"}.
Json end_to_end_file(const std::vector<EndToEndRun>& runs, int warm_up);
/// A table of what end_to_end_json gave.
std::string end_to_end_lines(const Json& run);

}  // namespace collided::cli
