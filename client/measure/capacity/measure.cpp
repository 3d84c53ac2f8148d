// What a few frames of a scene cost on a daemon.

#include "client/measure/capacity/measure.hpp"

#include <algorithm>

#include "client/app/output/progress.hpp"

namespace collided::cli {

namespace {

void count(const v1::FrameMetrics& metrics, Measured& measured) {
  const double share = 1.0 / measured.steps;
  const v1::FrameCounts& counts = metrics.counts();
  measured.engine_ms += share * metrics.engine_milliseconds();
  measured.bytes_out += share * static_cast<double>(metrics.bytes_out());
  measured.contacts += share * static_cast<double>(counts.contacts_vertex_triangle() + counts.contacts_edge_edge() +
                                                   counts.contacts_triangle_triangle() +
                                                   counts.contacts_edge_triangle() + counts.contacts_vertex_solid());
  measured.device_bytes = std::max(measured.device_bytes, metrics.device_bytes());
}

}  // namespace

Measured measure_scene(Connection& connection, const v1::SceneSpec& spec, std::span<const client::MeshInput> meshes,
                       const BenchInput& input, int steps) {
  const std::vector<int> plan = planned_steps(steps, steps);
  const SceneGuard scene = connection.create_scene(spec, meshes);
  client::FrameStream stream = connection.stream(*scene, 1);
  Measured measured{.steps = steps};
  Progress progress;
  for (size_t at = 0; at < plan.size(); ++at) {
    const client::FrameOutput output = run_frame(stream, planned_frame(input, plan, at, steps, spec));
    if (at >= static_cast<size_t>(steps)) count(output.done.metrics(), measured);
    progress.show(input.name + ": steps", static_cast<int>(at) + 1, static_cast<int>(plan.size()));
  }
  stream.finish();
  return measured;
}

}  // namespace collided::cli
