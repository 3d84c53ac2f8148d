// collidectl estimate: what a scene would cost, before it is made, and how many devices a workload needs.

#include <cstdio>
#include <memory>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/options/exclusion_options.hpp"
#include "client/app/options/finite.hpp"
#include "client/app/options/mesh_options.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/report/json.hpp"
#include "client/app/report/text.hpp"
#include "client/cli/commands.hpp"
#include "client/measure/bench/input.hpp"
#include "client/measure/capacity/measure.hpp"
#include "client/measure/capacity/report.hpp"

namespace collided::cli {

namespace {

struct EstimateOptions {
  ServerOptions server;
  DetectionOptions detection;
  ExclusionOptions exclusions;
  SceneOptions scene;
  std::vector<std::string> frames;
  uint32_t triangles = 0, vertices = 0;  ///< 0 triangles: of the frames or the scene; 0 vertices: by the triangles
  std::string position_format = "f32";
  Workload workload;
  bool measures = false;
  int steps = 20;
  bool json = false;
};

void check_usage(const EstimateOptions& options) {
  const int inputs = !options.frames.empty() + !options.scene.name.empty() + (options.triangles > 0);
  if (inputs != 1) throw UsageError("estimate needs one of FRAME, --scene and --triangles");
  if (options.measures && options.triangles > 0)
    throw UsageError("--measure needs positions: FRAME... or --scene, not --triangles");
  const size_t needed = options.detection.mode == "dcd" ? 1 : 2;
  if (options.measures && options.scene.name.empty() && options.frames.size() != needed)
    throw UsageError("--measure with --mode " + options.detection.mode + " needs " +
                     (needed == 1 ? "one frame, FRAME; " : "two frames, FRAME0 FRAME1; ") +
                     std::to_string(options.frames.size()) + (options.frames.size() == 1 ? " was" : " were") +
                     " given");
  if (options.workload.network_gigabits && !options.workload.has_network())
    throw UsageError("--network is of --transport grpc alone");
  check_usage(options.detection);
}

/// No meshes if there is but their size.
BenchInput read_input(const EstimateOptions& options) {
  if (options.triangles > 0) return {};
  return options.frames.empty() ? scene_input(options.scene.name, options.scene.scale) : file_input(options.frames);
}

/// One mesh of which nothing is known but its size. By Euler's formula a closed surface has half as many vertices as
/// triangles, and two more for a sphere.
void add_mesh(v1::SceneSpec& spec, const EstimateOptions& options) {
  v1::MeshSpec& mesh = *spec.add_meshes();
  mesh.set_name("mesh");
  mesh.set_triangle_count(options.triangles);
  mesh.set_vertex_count(options.vertices > 0 ? options.vertices : options.triangles / 2 + 2);
  const scenes::Vec3d unit_box[] = {{0, 0, 0}, {1, 1, 1}};
  grow_box(spec, unit_box);
}

v1::SceneSpec spec_of(const EstimateOptions& options, const BenchInput& input) {
  v1::SceneSpec spec = scene_spec(options.server, options.detection, format_of(options.position_format));
  spec.set_display_name("estimate");
  if (!input.meshes.empty()) grow_box(spec, input, options.steps);
  options.exclusions.exclude_meshes(spec, mesh_inputs(input.meshes));
  return spec;
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
            {"triangle_triangle", contact.triangle_triangle()},
            {"edge_triangle", contact.edge_triangle()},
            {"vertex_solid", contact.vertex_solid()}}},
          {"memory_bytes", memory_bytes(estimate)},
          {"first_frame_bytes", estimate.first_frame_bytes()},
          {"frame_bytes", estimate.frame_bytes()},
          {"stages", estimate.stages()}};
}

uint64_t usable_bytes_of(const EstimateOptions& options, const v1::EstimateSceneResponse& estimate,
                         const v1::GetServerInfoResponse& info) {
  if (options.workload.device_gigabytes) return usable_bytes(*options.workload.device_gigabytes * 1e9);
  for (const v1::Device& device : info.devices())
    if (device.backend() == estimate.spec().backend() && device.memory_bytes() > 0)
      return usable_bytes(static_cast<double>(device.memory_bytes()));
  return info.limits().max_device_bytes();  // of the host's memory, which a CPU has no own share of
}

SceneCost cost_of(const Workload& workload, const v1::EstimateSceneResponse& estimate,
                  const std::optional<Measured>& measured) {
  SceneCost cost;
  cost.memory_bytes = memory_bytes(estimate);
  cost.frame_bytes = estimate.frame_bytes();
  cost.step_ms = workload.step_ms;
  const v1::ContactBytes& contact = estimate.contact_bytes();
  if (workload.contacts)
    cost.bytes_out = static_cast<double>(*workload.contacts) *
                     std::max({contact.vertex_triangle(), contact.edge_edge(), contact.triangle_triangle(),
                               contact.edge_triangle(), contact.vertex_solid()});
  if (!measured) return cost;
  cost.memory_bytes = std::max(cost.memory_bytes, measured->device_bytes);
  if (!workload.contacts) cost.bytes_out = measured->bytes_out;
  cost.step_ms = measured->engine_ms;
  return cost;
}

Capacity capacity_of(const EstimateOptions& options) {
  const BenchInput input = read_input(options);
  const std::vector<client::MeshInput> meshes = described_inputs(input.meshes, options.detection);
  const v1::SceneSpec spec = spec_of(options, input);
  Connection connection(options.server);
  v1::SceneSpec estimated = spec;
  if (options.triangles > 0) add_mesh(estimated, options);
  Capacity capacity;
  capacity.workload = options.workload;
  capacity.estimate = connection->estimate_scene(estimated, meshes);
  if (options.measures) capacity.measured = measure_scene(connection, spec, meshes, input, options.steps);
  capacity.limits = connection->server_info().limits();
  capacity.usable_bytes = usable_bytes_of(options, capacity.estimate, connection->server_info());
  capacity.scene = cost_of(options.workload, capacity.estimate, capacity.measured);
  capacity.plan = plan_of(options.workload, capacity.scene, capacity.usable_bytes);
  return capacity;
}

std::string text_of(const Json& report, const Capacity& capacity) {
  std::string out = report_text(report) + "\n" + verdict(capacity) + "\n";
  for (const std::string& assumption : assumptions(capacity)) out += "assumed: " + assumption + "\n";
  for (const std::string& warning : limit_warnings(capacity)) out += "warning: " + warning + "\n";
  return out;
}

void run(const EstimateOptions& options) {
  check_usage(options);
  const Capacity capacity = capacity_of(options);
  Json report = estimate_json(capacity.estimate);
  add_capacity(report, capacity);
  if (!options.json) {
    std::printf("%s", text_of(report, capacity).c_str());
    return;
  }
  report["assumptions"] = assumptions(capacity);
  report["warnings"] = limit_warnings(capacity);
  std::printf("%s\n", json_text(report).c_str());
}

template <class T>
CLI::Option* add_number(CLI::App& command, const char* name, T& value, const char* help, double min, double max) {
  return command.add_option(name, value, help)->check(finite())->check(CLI::Range(min, max));
}

void add_input_options(CLI::App& command, EstimateOptions& options) {
  command
      .add_option("FRAME", options.frames,
                  "Mesh files, whose vertices and elements the scene has; --measure: FRAME0 FRAME1")
      ->type_name("FILE")
      ->expected(1, 2);
  CLI::Option* scene =
      command.add_option("--scene", options.scene.name, "Name of a scene instead, see 'collidectl scenes'")
          ->type_name("SCENE")
          ->check(known_scene());
  add_scale_option(command, options.scene.scale);
  command.get_option("--scale")->needs(scene);
  CLI::Option* triangles = command.add_option("--triangles", options.triangles, "Triangles of one mesh instead")
                               ->check(CLI::Range(1u, UINT32_MAX));
  command.add_option("--vertices", options.vertices, "Its vertices; default: half as many and 2, of a closed surface")
      ->check(CLI::Range(1u, UINT32_MAX))
      ->needs(triangles);
}

void add_workload_options(CLI::App& command, EstimateOptions& options) {
  Workload& workload = options.workload;
  command.add_option("--scenes", workload.scenes, "Scenes like this one")
      ->check(CLI::Range(1u, 100000000u))
      ->capture_default_str();
  add_number(command, "--rate", workload.rate, "Frames a second of each scene", 0.001, 1e6);
  CLI::Option* step =
      add_number(command, "--step-ms", workload.step_ms, "Milliseconds that a frame takes of a device", 1e-6, 1e7);
  CLI::Option* measure =
      command
          .add_flag("--measure", options.measures, "Play frames on the daemon for that, for memory and for contacts")
          ->excludes(step);
  command.add_option("--steps", options.steps, "Frames to measure, after as many that do not count")
      ->check(CLI::Range(1, 100000))
      ->needs(measure)
      ->capture_default_str();
  command.add_option("--contacts", workload.contacts, "Contacts that a frame sends back; default: those measured")
      ->check(CLI::Range(uint64_t{0}, uint64_t{1000000000}));
  command.add_option("--transport", workload.transport, "How frames go; but for grpc they take no network")
      ->check(CLI::IsMember({"grpc", "shared-memory", "device-memory"}))
      ->capture_default_str();
  add_number(command, "--gpu-memory", workload.device_gigabytes,
             "Memory of a GPU in GB (10^9 bytes); default: that of the daemon's", 1e-3, 1e6);
  add_number(command, "--network", workload.network_gigabits, "Gbit/s each way that a GPU has of its host's network",
             1e-3, 1e6);
  add_number(command, "--utilisation", workload.utilisation,
             "Share of its time, and of its network, that a GPU may be busy; the rest keeps queues short", 0.01, 1)
      ->capture_default_str();
}

constexpr auto kFooter =
    "Memory is the least that the scene holds after its first frame; how many candidates and contacts a frame\n"
    "finds depends on the positions and is not known without --measure. Otherwise nothing is made and nothing sent\n"
    "but the numbers of vertices and triangles, and which vertices loose edges and points have.\n"
    "\n"
    "A GPU's scenes share its memory, its time and its network; the scarcest decides. A scene is on one GPU, whose\n"
    "frames are taken one after the other: small scenes, which overlap, need less ('collidectl load --find-max').\n"
    "\n"
    "  collidectl estimate --scene reef_knot --scenes 200 --rate 60 --measure --network 25\n"
    "  collidectl estimate a.ply b.ply --scenes 50 --rate 30 --measure --server gpu-host:50551\n"
    "  collidectl estimate --triangles 1000000 --scenes 300 --rate 10 --step-ms 1.8 --gpu-memory 80";

}  // namespace

void add_estimate(CLI::App& app) {
  auto options = std::make_shared<EstimateOptions>();
  CLI::App& command = *app.add_subcommand("estimate", "What a scene would cost, and how many GPUs scenes like it need");
  command.footer(kFooter);
  add_input_options(command, *options);
  add_workload_options(command, *options);
  add_detection_options(command, options->detection);
  add_mesh_options(command, options->detection);
  add_mesh_pairs_option(command, options->exclusions);
  add_server_options(command, options->server);
  add_position_format_option(command, options->position_format);
  command.add_flag("--json", options->json, "Print one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
