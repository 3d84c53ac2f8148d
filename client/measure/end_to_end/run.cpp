// collidectl bench --end-to-end: whole frames over every transport, and the same bytes over bare sockets. They
// alternate frame by frame, so that other load on the machine affects all of them alike.

#include "client/measure/end_to_end/run.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/output/progress.hpp"
#include "client/app/report/numbers.hpp"
#include "client/measure/bench/output.hpp"
#include "client/measure/end_to_end/echo_peer.hpp"
#include "client/measure/end_to_end/frames.hpp"
#include "client/measure/end_to_end/report.hpp"
#include "client/measure/end_to_end/transports.hpp"

namespace collided::cli {

namespace {

using Clock = std::chrono::steady_clock;

/// A scene and a stream over one transport.
struct Lane {
  bool in_place = false;
  std::unique_ptr<SceneGuard> scene;
  client::FrameStream stream;
  TransportTimes times;
};

class EndToEnd {
 public:
  EndToEnd(EchoPeer& echo, const OwnDaemon& daemon, const EndToEndOptions& options)
      : echo_(echo),
        options_(options),
        transports_(transports_of(daemon)),
        client_(client::Client::connect(daemon.address())) {}

  EndToEndRun run(double scale);

 private:
  v1::SceneSpec spec() const {
    const BenchSettings& settings = options_.settings;
    return scene_spec(settings.server, settings.detection, format_of(settings.position_format));
  }
  std::vector<Lane> open_lanes(const scenes::Scene& input, EndToEndRun& run);
  double send(Lane& lane, const v1::Frame& frame, bool counts, double bytes_down);
  void compare(EndToEndRun& run, const Exchange& bytes, bool counts);
  void step(EndToEndRun& run, std::vector<Lane>& lanes, const v1::Frame& frame, bool counts);

  EchoPeer& echo_;
  const EndToEndOptions& options_;
  std::vector<Transport> transports_;
  client::Client client_;
  double engine_ms_ = 0;  ///< of the last frame
};

std::vector<Lane> EndToEnd::open_lanes(const scenes::Scene& input, EndToEndRun& run) {
  std::vector<Lane> lanes;
  for (const Transport& transport : transports_) {
    auto scene = std::make_unique<SceneGuard>(client_, client_.create_scene(spec(), mesh_inputs(input.meshes())));
    run.scene = **scene;
    client::FrameStream stream = transport.open(**scene);
    lanes.push_back({transport.in_place, std::move(scene), std::move(stream), {.name = transport.name, .frames = {}}});
  }
  return lanes;
}

/// Sends one frame and waits for its answer. Returns the bytes of its contacts, which must be `bytes_down`, those of
/// the previous lane; -1: this is the first lane.
double EndToEnd::send(Lane& lane, const v1::Frame& frame, bool counts, double bytes_down) {
  std::vector<client::FrameUpdate> updates = views_of(frame);
  if (lane.in_place) move_to_input(lane.stream, updates);
  const auto start = Clock::now();
  lane.stream.send(frame.frame_id(), updates);
  const client::FrameOutput output = receive(lane.stream);
  const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  output.check();
  const double bytes = bytes_of(output);
  if (bytes_down >= 0 && bytes != bytes_down)
    throw std::runtime_error("frame " + std::to_string(frame.frame_id()) + " over " + lane.times.name + " has " +
                             format_double("%.0f", bytes) + " bytes of contacts, over another transport " +
                             format_double("%.0f", bytes_down));
  const FrameTime time = frame_time(ms, output.done.metrics());
  engine_ms_ = time.engine;
  if (counts) lane.times.frames.push_back(time);
  return bytes;
}

void EndToEnd::step(EndToEndRun& run, std::vector<Lane>& lanes, const v1::Frame& frame, bool counts) {
  double bytes_down = -1;
  for (size_t i = 0; i < lanes.size(); ++i)  // each lane in turn goes first, with cold caches
    bytes_down = send(lanes[(i + frame.frame_id()) % lanes.size()], frame, counts, bytes_down);
  const double bytes_up = bytes_of(views_of(frame));
  compare(run, {.up = static_cast<size_t>(bytes_up), .down = static_cast<size_t>(bytes_down)}, counts);
  if (!counts) return;
  run.bytes_up.push_back(bytes_up);
  run.bytes_down.push_back(bytes_down);
}

/// The same bytes over bare sockets: answered at once, then paced like real frames (pauses before each exchange and
/// before its answer), so that CPU sleep costs every transport alike.
void EndToEnd::compare(EndToEndRun& run, const Exchange& bytes, bool counts) {
  constexpr double kMaxHoldMs = 100;
  const double hold_ms = std::min(engine_ms_, kMaxHoldMs);
  const auto after_pause = [&](const auto& exchange) {
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(hold_ms));
    return exchange();
  };
  const double tcp = echo_.tcp_ms(bytes), unix_stream = echo_.unix_ms(bytes);
  const Exchange held{bytes.up, bytes.down, hold_ms};
  const double held_tcp = after_pause([&] { return echo_.tcp_ms(held); });
  const double held_unix = after_pause([&] { return echo_.unix_ms(held); });
  const double control = after_pause([&] { return echo_.unix_ms({kControlBytes, kControlBytes, hold_ms}); });
  if (!counts) return;
  run.bare.tcp.push_back(tcp);
  run.bare.unix_stream.push_back(unix_stream);
  run.held.tcp.push_back(held_tcp);
  run.held.unix_stream.push_back(held_unix);
  run.held_control.push_back(control);
}

EndToEndRun EndToEnd::run(double scale) {
  const auto scene = scenes::make_scene(options_.scene, scale);
  const BenchSettings& settings = options_.settings;
  EndToEndRun run;
  run.name = options_.scene;
  run.scale = scale;
  std::vector<Lane> lanes = open_lanes(*scene, run);
  const std::string what = run.name + ", scale " + format_double("%.4g", scale) + ": frames";
  const int frames = settings.warm_up + settings.steps;
  Progress progress;
  for (int at = 0; at < frames; ++at) {
    step(run, lanes, frame_at(*scene, at, spec()), at >= settings.warm_up);
    progress.show(what, at + 1, frames);
  }
  for (Lane& lane : lanes) {
    lane.stream.finish();
    run.transports.push_back(std::move(lane.times));
  }
  return run;
}

void run_scales(EndToEnd& bench, const std::vector<double>& scales, int warm_up, BenchOutput& output) {
  std::vector<EndToEndRun> runs;
  for (const double scale : scales) {
    runs.push_back(bench.run(scale));
    output.show(end_to_end_lines(end_to_end_json(runs.back())));
    output.keep(end_to_end_file(runs, warm_up));
  }
}

}  // namespace

void run_end_to_end(const EndToEndOptions& options) {
  EchoPeer echo;
  std::vector<double> scales{options.scale};
  for (const double megabytes : options.megabytes)
    scales.push_back(scale_for(options.scene, megabytes, format_of(options.settings.position_format)));
  const ServerOptions& server = options.settings.server;
  const OwnDaemon daemon({.backend = server.backend, .threads = server.threads, .tcp = true});
  EndToEnd bench(echo, daemon, options);
  defer_interrupts();
  BenchOutput output(options.out, options.json);
  try {
    run_scales(bench, scales, options.settings.warm_up, output);
  } catch (const std::exception&) {
    output.finish();
    throw;
  }
  output.finish();
}

}  // namespace collided::cli
