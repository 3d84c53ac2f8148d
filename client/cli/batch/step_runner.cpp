// Detects the contacts of steps that have nothing to do with each other.

#include "client/cli/batch/step_runner.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <cstdio>

#include "client/app/input/mesh_input.hpp"
#include "client/app/output/csv.hpp"
#include "client/cpp/error.hpp"

namespace collided::cli {

namespace {

/// Whether the daemon refused the step itself, and would do so again. A shared daemon may be full for others' sake.
bool is_refusal(const client::Error& error, bool is_own_daemon) {
  switch (error.code()) {
    case grpc::INVALID_ARGUMENT:
    case grpc::OUT_OF_RANGE:
      return true;
    case grpc::RESOURCE_EXHAUSTED:
      return is_own_daemon;
    default:
      return false;
  }
}

}  // namespace

StepRunner::StepRunner(const BatchOptions& options) : options_(options) { connection_.emplace(options.server); }

StepResult StepRunner::run(const StepInput& step) {
  const bool is_own_daemon = options_.server.server.empty();
  for (bool is_second = false;; is_second = true) try {
      return try_once(step);
    } catch (const client::Error& error) {
      check_interrupt();  // which may have ended the daemon
      if (is_refusal(error, is_own_daemon)) throw StepRefused(error.what());
      if (!is_own_daemon || error.code() != grpc::UNAVAILABLE) throw;
      std::fputs("its daemon has ended; another one is started\n", stderr);
      connection_.reset();
      connection_.emplace(options_.server);
      if (is_second) throw StepRefused(std::string("the daemon ended, twice: ") + error.what());
    }
}

StepResult StepRunner::try_once(const StepInput& step) {
  std::vector<client::MeshInput> meshes = mesh_inputs(step.meshes);
  for (client::MeshInput& mesh : meshes) mesh.exclude_rings = options_.exclude_rings;
  v1::SceneSpec spec =
      scene_spec(options_.server, options_.detection, choose_format(options_.position_format, step.is_double));
  connection_->ask_for_all_fields(spec);  // whether contacts are kept or not: their digest tells of all
  grow_box(spec, step.start);
  grow_box(spec, step.end);
  const v1::Frame frame = step_frame(step, 1, spec);
  const SceneGuard scene = connection_->create_scene(spec, meshes);
  client::FrameStream stream = connection_->stream(*scene);
  client::FrameOutput output = run_frame(stream, frame);
  stream.finish();
  return {*scene, std::move(output)};
}

std::string StepRunner::contact_rows(uint64_t pair, const StepInput& step, const StepResult& result) const {
  if (!options_.keep_contacts) return "";
  std::optional<client::SceneFeatures> scene;
  if (asks_for_crossings(result.scene.spec())) scene.emplace(mesh_inputs(step.meshes));
  return csv_rows(std::to_string(pair) + ",", result.output, {step.start, step.end, scene ? &*scene : nullptr});
}

}  // namespace collided::cli
