// collidectl stream: plays a procedural scene through a daemon and tells what its frames cost.

#include <chrono>
#include <cstdio>
#include <memory>

#include "client/cli/commands.hpp"
#include "client/cli/connection.hpp"
#include "client/cli/interrupt.hpp"
#include "client/cli/mesh_input.hpp"
#include "client/cli/progress.hpp"
#include "client/cli/report.hpp"
#include "client/cli/scene_options.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

namespace {

struct StreamOptions {
  ServerOptions server;
  DetectionOptions detection;
  SceneOptions scene;
  std::string position_format = "f32";
  bool json = false;
};

/// What is kept of the frames: the contacts themselves are counted and let go.
struct Totals {
  std::vector<v1::FrameMetrics> metrics;
  v1::FrameDone last;
  uint64_t contacts = 0, vertex_triangle = 0, edge_edge = 0, triangle_triangle = 0;
  uint64_t bytes_in = 0, bytes_out = 0, replays = 0;
  bool any_contact = false;
  double earliest_toi = 1;

  void add(client::FrameOutput output) {
    output.check();
    const v1::FrameMetrics& m = output.done.metrics();
    contacts += output.done.contact_count();
    vertex_triangle += output.vertex_triangle.count;
    edge_edge += output.edge_edge.count;
    triangle_triangle += output.triangle_triangle.count;
    any_contact |= output.done.any_contact();
    bytes_in += m.bytes_in();
    bytes_out += m.bytes_out();
    replays += m.replays();
    earliest_toi = std::min(earliest_toi, output.done.earliest_toi());
    metrics.push_back(m);
    last = std::move(output.done);
  }
};

Totals play(client::FrameStream& stream, const scenes::Scene& scene, const SceneOptions& options,
            v1::PositionFormat format) {
  Totals totals;
  Progress progress;
  const auto receive = [&] {
    check_interrupt();
    totals.add(stream.receive());
    progress.show("frames", static_cast<int>(totals.metrics.size()), options.frames);
  };
  for (int sent = 0; sent < options.frames; ++sent) {
    check_interrupt();
    if (sent >= static_cast<int>(totals.metrics.size() + stream.window())) receive();
    const auto id = static_cast<uint64_t>(sent) + 1;
    stream.send(make_frame(scene.meshes(), id, format, scene.positions(options.time(sent))));
  }
  while (static_cast<int>(totals.metrics.size()) < options.frames) receive();
  check_interrupt();
  stream.finish();
  return totals;
}

Json summary(const StreamOptions& options, const v1::Scene& scene, const Totals& totals, double seconds) {
  const Json contacts = {{"all", totals.contacts},
                         {"vertex_triangle", totals.vertex_triangle},
                         {"edge_edge", totals.edge_edge},
                         {"triangle_triangle", totals.triangle_triangle}};
  return {{"name", options.scene.name},
          {"scale", options.scene.scale},
          {"scene", scene_json(scene)},
          {"frames", options.scene.frames},
          {"seconds", seconds},
          {"median_stage_ms", median_stages(totals.metrics)},
          {"last_frame_counts", counts_json(totals.last.metrics().counts())},
          {"contacts", contacts},
          {"any_contact", totals.any_contact},
          {"earliest_toi", totals.earliest_toi},
          {"replays", totals.replays},
          {"warnings", warnings_json(totals.metrics)},
          {"bytes",
           {{"device", totals.last.metrics().device_bytes()}, {"in", totals.bytes_in}, {"out", totals.bytes_out}}}};
}

void run(const StreamOptions& options) {
  check_usage(options.detection);
  const auto procedural = scenes::make_scene(options.scene.name, options.scene.scale);
  const v1::PositionFormat format = format_of(options.position_format);
  Connection connection(options.server);
  v1::SceneSpec spec = scene_spec(options.server, options.detection, format);
  spec.set_display_name(options.scene.name);
  const SceneGuard scene = connection.create_scene(spec, mesh_inputs(procedural->meshes()));
  client::FrameStream stream = connection->stream(*scene);
  const auto start = std::chrono::steady_clock::now();
  const Totals totals = play(stream, *procedural, options.scene, format);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const Json out = summary(options, *scene, totals, took.count());
  if (options.json)
    std::printf("%s\n", out.dump().c_str());
  else
    print_text(out);
}

}  // namespace

void add_stream(CLI::App& app) {
  auto options = std::make_shared<StreamOptions>();
  CLI::App& command = *app.add_subcommand("stream", "Play a procedural scene and tell what its frames cost");
  add_scene_options(command, options->scene);
  add_detection_options(command, options->detection);
  add_server_options(command, options->server);
  add_position_format_option(command, options->position_format);
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
