// collidectl estimate: what a scene would cost, before it is made.

#include <cstdio>
#include <memory>

#include "client/cli/commands.hpp"
#include "client/cli/daemon/connection.hpp"
#include "client/cli/input/mesh_input.hpp"
#include "client/cli/input/step_input.hpp"
#include "client/cli/options/exclusion_options.hpp"
#include "client/cli/options/options.hpp"
#include "client/cli/options/scene_options.hpp"
#include "client/cli/options/usage_error.hpp"
#include "client/cli/report/json.hpp"
#include "client/cli/report/text.hpp"

namespace collided::cli {

namespace {

struct EstimateOptions {
  ServerOptions server;
  DetectionOptions detection;
  ExclusionOptions exclusions;
  SceneOptions scene;
  std::string frame;
  std::string position_format = "f32";
  bool json = false;
};

void check_usage(const EstimateOptions& options) {
  if (options.scene.name.empty() == options.frame.empty()) throw UsageError("estimate needs one of FRAME and --scene");
  check_usage(options.detection);
}

StepInput read_input(const EstimateOptions& options) {
  return options.frame.empty() ? scene_step(options.scene) : file_frame(options.frame);
}

Json memory_json(const v1::EstimateSceneResponse& estimate) {
  Json parts = Json::object();
  for (const v1::MemoryPart& part : estimate.memory()) parts[part.part()] = part.bytes();
  return parts;
}

uint64_t memory_bytes(const v1::EstimateSceneResponse& estimate) {
  uint64_t bytes = 0;
  for (const v1::MemoryPart& part : estimate.memory()) bytes += part.bytes();
  return bytes;
}

Json estimate_json(const v1::EstimateSceneResponse& estimate) {
  v1::Scene scene;
  *scene.mutable_spec() = estimate.spec();
  scene.set_device(estimate.device());
  scene.set_vertex_count(estimate.vertex_count());
  scene.set_triangle_count(estimate.triangle_count());
  Json described = scene_json(scene);
  described.erase("edges");  // not counted
  const v1::ContactBytes& contact = estimate.contact_bytes();
  return {{"scene", described},
          {"part_bytes", memory_json(estimate)},
          {"contact_bytes",
           {{"vertex_triangle", contact.vertex_triangle()},
            {"edge_edge", contact.edge_edge()},
            {"triangle_triangle", contact.triangle_triangle()}}},
          {"memory_bytes", memory_bytes(estimate)},
          {"first_frame_bytes", estimate.first_frame_bytes()},
          {"frame_bytes", estimate.frame_bytes()},
          {"stages", estimate.stages()}};
}

void run(const EstimateOptions& options) {
  check_usage(options);
  const StepInput input = read_input(options);
  v1::SceneSpec spec = scene_spec(options.server, options.detection, format_of(options.position_format));
  grow_box(spec, input.end);
  const std::vector<client::MeshInput> meshes = mesh_inputs(input.meshes);
  options.exclusions.exclude_meshes(spec, meshes);
  Connection connection(options.server);
  const Json estimate = estimate_json(connection->estimate_scene(spec, meshes));
  std::printf("%s", options.json ? (estimate.dump() + "\n").c_str() : report_text(estimate).c_str());
}

}  // namespace

void add_estimate(CLI::App& app) {
  auto options = std::make_shared<EstimateOptions>();
  CLI::App& command = *app.add_subcommand("estimate", "What a scene would cost, without making it");
  command.footer(
      "Memory is the least that the scene holds after its first frame; how many candidates and contacts a frame\n"
      "finds depends on the positions and is not known. Nothing is sent but the numbers of vertices and triangles, "
      "and\n"
      "which vertices loose edges and points have.");
  command.add_option("FRAME", options->frame, "OBJ or PLY, whose vertices and elements the scene has")
      ->type_name("FILE");
  CLI::Option* scene =
      command.add_option("--scene", options->scene.name, "Name of a scene instead, see 'collidectl scenes'")
          ->type_name("SCENE");
  add_scale_option(command, options->scene.scale);
  command.get_option("--scale")->needs(scene);
  add_detection_options(command, options->detection);
  add_mesh_pairs_option(command, options->exclusions);
  add_server_options(command, options->server);
  add_position_format_option(command, options->position_format);
  command.add_flag("--json", options->json, "Print one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
