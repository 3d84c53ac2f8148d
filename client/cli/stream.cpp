// collidectl stream: plays mesh files or a procedural scene through a daemon and reports what the frames cost.

#include <memory>
#include <optional>

#include "client/cli/commands.hpp"
#include "client/cli/daemon/connection.hpp"
#include "client/cli/input/mesh_input.hpp"
#include "client/cli/input/motion.hpp"
#include "client/cli/input/rigid_motion.hpp"
#include "client/cli/options/exclusion_options.hpp"
#include "client/cli/options/options.hpp"
#include "client/cli/options/scene_options.hpp"
#include "client/cli/options/usage_error.hpp"
#include "client/cli/output/output.hpp"
#include "client/cli/recording/writer.hpp"
#include "client/measure/play/run.hpp"

namespace collided::cli {

namespace {

struct StreamOptions {
  ServerOptions server;
  DetectionOptions detection;
  ExclusionOptions exclusions;
  SceneOptions scene;
  std::vector<std::string> files;
  std::vector<std::string> rigid;  ///< names of meshes
  std::string position_format = kAutomaticFormat;
  std::string record;
  bool json = false;
};

void check_usage(const StreamOptions& options) {
  if (options.scene.name.empty() == options.files.empty()) throw UsageError("stream needs one of FRAME... and --scene");
  check_usage(options.detection);
  if (is_standard_output(options.record)) throw UsageError("--record writes a file; standard output (-) is none");
}

/// What a stream plays.
struct Play {
  const StreamOptions& options;
  const Motion& motion;
  v1::SceneSpec spec;
  std::vector<uint32_t> rigid;  ///< indices of meshes
};

v1::SceneSpec spec_of(const StreamOptions& options, const Motion& motion) {
  v1::SceneSpec spec =
      scene_spec(options.server, options.detection, choose_format(options.position_format, motion.is_double));
  spec.set_display_name(options.scene.name);
  spec.set_rest_distance(options.exclusions.rest_distance);
  grow_box(spec, motion);
  return spec;
}

FrameSource frames_of(const Play& played) {
  const auto rigid = std::make_shared<RigidMotion>(played.motion.meshes, played.rigid);
  const auto sent = std::make_shared<int>(0);
  const auto next = [&played, rigid, sent]() -> std::optional<v1::Frame> {
    const Motion& motion = played.motion;
    if (*sent == motion.frames) return {};
    std::vector<scenes::Vec3d> positions = motion.positions(*sent);
    v1::Frame frame = make_frame(motion.meshes, static_cast<uint64_t>(++*sent), played.spec, positions);
    frame.set_advance(played.options.detection.advance);
    if (!played.rigid.empty()) rigid->apply_to(frame, std::move(positions));
    return frame;
  };
  return {.frames = played.motion.frames, .next = next};
}

/// From now on the frames are recorded as they are sent.
void record(FrameSource& source, RecordingWriter& recording) {
  source.next = [next = std::move(source.next), &recording] {
    std::optional<v1::Frame> frame = next();
    if (frame) recording.add(*frame);
    return frame;
  };
}

Json input_json(const StreamOptions& options, const Motion& motion) {
  if (motion.files.empty()) return {{"name", motion.name}, {"scale", options.scene.scale}};
  return {{"name", motion.name}};
}

void run(const StreamOptions& options) {
  check_usage(options);
  check_writable("--record", options.record);
  const Motion motion = options.files.empty() ? scene_motion(options.scene) : file_motion(options.files);
  std::vector<client::MeshInput> meshes = mesh_inputs(motion.meshes);
  options.exclusions.apply_to(meshes);
  Play played{options, motion, spec_of(options, motion), {}};
  options.exclusions.exclude_meshes(played.spec, meshes);
  for (const std::string& name : options.rigid) {
    played.rigid.push_back(mesh_of(meshes, "--rigid", name));
    meshes[played.rigid.back()].is_rigid = true;
  }
  Connection connection(options.server);
  const SceneGuard scene = connection.create_scene(played.spec, meshes);
  client::FrameStream stream = connection.stream(*scene);
  FrameSource source = frames_of(played);
  std::optional<RecordingWriter> recording;
  if (!options.record.empty()) record(source, recording.emplace(options.record, played.spec, meshes));
  const PlayOptions how{.input = input_json(options, motion),
                        .has_lines = !motion.files.empty() || recording,
                        .files = motion.files,
                        .json = options.json};
  try {
    play_and_report(stream, *scene, source, how);
  } catch (const std::exception&) {  // what was sent until then can be played again
    if (recording) recording->finish();
    throw;
  }
  if (recording) recording->finish();
}

}  // namespace

void add_stream(CLI::App& app) {
  auto options = std::make_shared<StreamOptions>();
  CLI::App& command =
      *app.add_subcommand("stream", "Play mesh files or a procedural scene and tell what the frames cost");
  command.add_option("FRAME", options->files, "OBJ or PLY, a frame each, in natural order: frame2 before frame10");
  add_optional_scene_options(command, options->scene);
  add_detection_options(command, options->detection);
  add_advance_options(command, options->detection);
  command.add_option("--rigid", options->rigid, "Meshes that move as rigid bodies, and send poses, such as ball")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_mesh_pairs_option(command, options->exclusions);
  add_ring_option(command, options->exclusions);
  add_rest_options(command, options->exclusions);
  add_server_options(command, options->server);
  add_automatic_format_option(command, options->position_format);
  command.add_option("--record", options->record, "File that takes the scene and its frames, for 'collidectl replay'");
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
