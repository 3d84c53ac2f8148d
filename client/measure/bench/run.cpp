// Plays an input on a daemon and records the cost of its frames.

#include "client/measure/bench/run.hpp"

#include "client/app/input/mesh_input.hpp"
#include "client/app/output/progress.hpp"

namespace collided::cli {

namespace {

/// Appends the metrics of the steps after the warm-up.
void play(client::FrameStream& stream, const BenchSettings& settings, const BenchInput& input,
          const v1::SceneSpec& spec, std::vector<v1::FrameMetrics>& metrics) {
  const std::vector<int> plan = planned_steps(settings.steps, settings.warm_up);
  const std::string what = input.name + ", " + settings.detection.engine + ": steps";
  Progress progress;
  for (size_t at = 0; at < plan.size(); ++at) {
    client::FrameOutput output = run_frame(stream, planned_frame(input, plan, at, settings.steps, spec));
    if (at >= static_cast<size_t>(settings.warm_up)) metrics.push_back(std::move(*output.done.mutable_metrics()));
    progress.show(what, static_cast<int>(at) + 1, static_cast<int>(plan.size()));
  }
  stream.finish();
}

}  // namespace

BenchRun measure(Connection& connection, const BenchSettings& settings, const BenchInput& input) {
  v1::SceneSpec spec = scene_spec(settings.server, settings.detection, format_of(settings.position_format));
  spec.set_display_name("bench");
  grow_box(spec, input, settings.steps);
  const SceneGuard scene = connection.create_scene(spec, mesh_inputs(input.meshes));
  client::FrameStream stream = connection.stream(*scene, 1);
  BenchRun run;
  run.name = input.name;
  try {
    play(stream, settings, input, spec, run.steps);
  } catch (const Interrupted&) {
    run.interrupted = std::current_exception();
  }
  run.scene = connection->get_scene(scene->scene_id());
  return run;
}

}  // namespace collided::cli
