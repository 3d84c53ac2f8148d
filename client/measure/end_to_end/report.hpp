#pragma once
// Results of 'collidectl bench --end-to-end' as JSON and as a table.

#include <string>
#include <vector>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// One frame over one transport; times in milliseconds.
struct FrameTime {
  double latency = 0;  ///< from sending the frame to its complete answer
  double engine = 0;   ///< the engine's part of it
  double decode = 0, encode = 0, queue = 0;
};

/// The frames of one transport, in their order; 1 or more.
struct TransportTimes {
  std::string name;
  std::vector<FrameTime> frames;
};

/// The same bytes over bare sockets, milliseconds for each frame.
struct BareTimes {
  std::vector<double> tcp, unix_stream;
};

/// About the size of a control message; shared memory needs one each way.
constexpr size_t kControlBytes = 64;

/// One size of one scene.
struct EndToEndRun {
  std::string name;
  double scale = 1;
  v1::Scene scene;
  std::vector<TransportTimes> transports;
  BareTimes bare;                            ///< sockets answer at once
  BareTimes held;                            ///< sockets answer after the engine's time, as for a real frame
  std::vector<double> held_control;          ///< the same for kControlBytes each way over the Unix socket
  std::vector<double> bytes_up, bytes_down;  ///< positions and contacts of each frame
};

/// The engine's time is the daemon's or, if it sends none, the sum of the stages.
FrameTime frame_time(double latency, const v1::FrameMetrics& metrics);

/// Overhead is a frame's latency less the engine's time; its ratios are ratios of medians.
Json end_to_end_json(const EndToEndRun& run);
/// The whole file: {"device", "settings", "runs"}.
Json end_to_end_file(const std::vector<EndToEndRun>& runs, int warm_up);
/// The table of an end_to_end_json().
std::string end_to_end_lines(const Json& run);

}  // namespace collided::cli
