// collidectl bench --end-to-end: whole frames over every transport, and the same bytes over bare sockets. All take
// turns frame by frame, so that what else the machine does falls on all alike.

#include "client/cli/end_to_end.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "client/cli/bench_output.hpp"
#include "client/cli/echo_peer.hpp"
#include "client/cli/end_to_end_report.hpp"
#include "client/cli/end_to_end_ways.hpp"
#include "client/cli/mesh_input.hpp"
#include "client/cli/progress.hpp"
#include "client/cli/text.hpp"

namespace collided::cli {

namespace {

using Clock = std::chrono::steady_clock;

double positions_megabytes(const scenes::Scene& scene, v1::PositionFormat format) {
  double vertices = 0;
  for (const scenes::Mesh& mesh : scene.meshes())
    if (!mesh.is_static) vertices += mesh.vertex_count;
  return vertices * (format == v1::POSITION_FORMAT_F64 ? 24 : 12) * 1e-6;
}

/// Time of a frame: to and fro in the middle of the motion, in steps of a simulator, so that frames are alike however
/// many there are.
double time_of(int frame) {
  constexpr int kThere = 60;
  constexpr double kFrom = 0.5, kStep = 1.0 / 600;
  const int at = frame % (2 * kThere);
  return kFrom + kStep * std::min(at, 2 * kThere - at);
}

/// CCD goes on from the frame before; the first one starts one step earlier.
v1::Frame frame_at(const scenes::Scene& scene, int frame, const v1::SceneSpec& spec) {
  std::vector<scenes::Vec3d> start;
  if (frame == 0 && spec.mode() == v1::DETECTION_MODE_CCD) start = scene.positions(time_of(0));
  return make_frame(scene.meshes(), static_cast<uint64_t>(frame) + 1, spec.position_format(),
                    scene.positions(time_of(frame + 1)), start);
}

/// The frame's positions, where they lie.
std::vector<client::FrameUpdate> views_of(const v1::Frame& frame) {
  std::vector<client::FrameUpdate> out;
  for (const v1::MeshUpdate& update : frame.updates())
    out.push_back({.mesh = update.mesh(),
                   .positions = std::as_bytes(std::span(update.positions())),
                   .start_positions = std::as_bytes(std::span(update.start_positions()))});
  return out;
}

/// Moves them to the memory that the stream shares with the daemon.
void put_in(client::FrameStream& stream, std::vector<client::FrameUpdate>& updates) {
  const auto put = [&](std::span<const std::byte>& bytes) {
    const std::span<std::byte> there = stream.input(bytes.size());
    std::copy(bytes.begin(), bytes.end(), there.begin());
    bytes = there;
  };
  for (client::FrameUpdate& update : updates) {
    put(update.positions);
    if (!update.start_positions.empty()) put(update.start_positions);
  }
}

double bytes_of(const std::vector<client::FrameUpdate>& updates) {
  size_t bytes = 0;
  for (const client::FrameUpdate& update : updates) bytes += update.positions.size() + update.start_positions.size();
  return static_cast<double>(bytes);
}

double bytes_of(const client::Contacts& contacts) {
  const auto bytes = [](const auto& values) { return static_cast<double>(std::span(values).size_bytes()); };
  return bytes(contacts.elements) + bytes(contacts.stencils) + bytes(contacts.toi) + bytes(contacts.distance) +
         bytes(contacts.weights) + bytes(contacts.flags);
}

/// A scene and a stream over one transport.
struct Lane {
  bool in_place = false;
  std::unique_ptr<SceneGuard> scene;
  client::FrameStream stream;
  WayTimes times;
};

class EndToEnd {
 public:
  EndToEnd(EchoPeer& echo, const OwnDaemon& daemon, const EndToEndOptions& options)
      : echo_(echo), options_(options), ways_(ways_of(daemon)), client_(client::Client::connect(daemon.address())) {}

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
  std::vector<Way> ways_;
  client::Client client_;
  double engine_ms_ = 0;  ///< of the last frame
};

std::vector<Lane> EndToEnd::open_lanes(const scenes::Scene& input, EndToEndRun& run) {
  std::vector<Lane> lanes;
  for (const Way& way : ways_) {
    auto scene = std::make_unique<SceneGuard>(client_, client_.create_scene(spec(), mesh_inputs(input.meshes())));
    run.scene = **scene;
    client::FrameStream stream = way.open(**scene);
    lanes.push_back({way.in_place, std::move(scene), std::move(stream), {.name = way.name, .frames = {}}});
  }
  return lanes;
}

/// Sends one frame and waits for its answer; returns the bytes of its contacts, which must be those of the lane before.
double EndToEnd::send(Lane& lane, const v1::Frame& frame, bool counts, double bytes_down) {
  std::vector<client::FrameUpdate> updates = views_of(frame);
  if (lane.in_place) put_in(lane.stream, updates);
  const auto start = Clock::now();
  lane.stream.send(frame.frame_id(), updates);
  const client::FrameOutput output = receive(lane.stream);
  const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  output.check();
  const double bytes =
      bytes_of(output.vertex_triangle) + bytes_of(output.edge_edge) + bytes_of(output.triangle_triangle);
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
  for (size_t i = 0; i < lanes.size(); ++i)  // none is always the first, whose caches are cold
    bytes_down = send(lanes[(i + frame.frame_id()) % lanes.size()], frame, counts, bytes_down);
  const double bytes_up = bytes_of(views_of(frame));
  compare(run, {.up = static_cast<size_t>(bytes_up), .down = static_cast<size_t>(bytes_down)}, counts);
  if (!counts) return;
  run.bytes_up.push_back(bytes_up);
  run.bytes_down.push_back(bytes_down);
}

/// The same bytes over bare sockets, answered at once, and in the rhythm of the frames: each begins as long after the
/// one before, and is answered as late. Meanwhile processors fall asleep, over any transport.
void EndToEnd::compare(EndToEndRun& run, const Exchange& bytes, bool counts) {
  constexpr double kLongEnough = 100;
  const double hold_ms = std::min(engine_ms_, kLongEnough);
  const auto after_a_pause = [&](const auto& exchange) {
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(hold_ms));
    return exchange();
  };
  const double tcp = echo_.tcp_ms(bytes), unix_stream = echo_.unix_ms(bytes);
  const Exchange held{bytes.up, bytes.down, hold_ms};
  const double held_tcp = after_a_pause([&] { return echo_.tcp_ms(held); });
  const double held_unix = after_a_pause([&] { return echo_.unix_ms(held); });
  const double few = after_a_pause([&] { return echo_.unix_ms({kFewBytes, kFewBytes, hold_ms}); });
  if (!counts) return;
  run.bare.tcp.push_back(tcp);
  run.bare.unix_stream.push_back(unix_stream);
  run.held.tcp.push_back(held_tcp);
  run.held.unix_stream.push_back(held_unix);
  run.held_few.push_back(few);
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
    run.ways.push_back(std::move(lane.times));
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

double scale_for(const std::string& scene, double megabytes, v1::PositionFormat format) {
  double best = 1, scale = 1, best_error = HUGE_VAL;
  for (int tries = 0; tries < 4; ++tries) {  // bytes grow by about the square of the scale
    const double bytes = positions_megabytes(*scenes::make_scene(scene, scale), format);
    if (const double error = std::abs(bytes - megabytes); error < best_error) {
      best = scale;
      best_error = error;
    }
    scale *= std::sqrt(megabytes / bytes);
  }
  return best;
}

void run_end_to_end(const EndToEndOptions& options) {
  EchoPeer echo;
  std::vector<double> scales{options.scale};
  for (const double megabytes : options.megabytes)
    scales.push_back(scale_for(options.scene, megabytes, format_of(options.settings.position_format)));
  const ServerOptions& server = options.settings.server;
  const OwnDaemon daemon({.backend = server.backend, .threads = server.threads, .all_transports = true});
  EndToEnd bench(echo, daemon, options);
  note_interrupts();
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
