// collidectl stream: plays mesh files or a procedural scene through a daemon and reports what the frames cost.

#include <deque>
#include <memory>
#include <optional>
#include <utility>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/frame_files.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/input/motion.hpp"
#include "client/app/input/rigid_motion.hpp"
#include "client/app/options/exclusion_options.hpp"
#include "client/app/options/mesh_options.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/contact_files.hpp"
#include "client/app/output/numbered.hpp"
#include "client/app/output/output.hpp"
#include "client/cli/commands.hpp"
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
  ContactFileNames contacts;
  bool json = false;
};

/// Of all frames.
std::vector<NamedOutput> outputs_of(const StreamOptions& options) {
  std::vector<NamedOutput> outputs{{"--record", options.record}};
  for (uint64_t frame = 1; frame <= options.files.size(); ++frame) {
    outputs.push_back({"--out", numbered(options.contacts.csv, frame)});
    outputs.push_back({"--vtp", numbered(options.contacts.vtp, frame)});
    outputs.push_back({"--ply", numbered(options.contacts.ply, frame)});
  }
  return outputs;
}

void check_usage(const StreamOptions& options) {
  if (options.scene.name.empty() == options.files.empty()) throw UsageError("stream needs one of FRAME... and --scene");
  check_usage(options.detection);
  if (is_standard_output(options.record)) throw UsageError("--record writes a file; standard output (-) is none");
  check_one_output(options.contacts.csv, options.json);
  if (!options.contacts.is_empty() && (options.detection.advance || !options.rigid.empty()))
    throw UsageError("--out, --vtp and --ply need straight, whole steps, not --advance or --rigid");
  const ContactFileNames& names = options.contacts;
  check_distinct({{"--record", options.record},
                  {"--out", names.csv},
                  {"--vtp", names.vtp},
                  {"--ply", names.ply},
                  {"the series of --vtp", names.vtp.empty() ? "" : series_name(names.vtp)}});
  check_kept(options.files, outputs_of(options));
}

/// What a stream plays.
struct Play {
  const StreamOptions& options;
  const Motion& motion;
  v1::SceneSpec spec;
  std::vector<uint32_t> rigid;                            ///< indices of meshes
  std::deque<std::vector<scenes::Vec3d>> in_flight = {};  ///< positions of frames without an answer, if files need them
};

v1::SceneSpec spec_of(const StreamOptions& options, const Motion& motion) {
  v1::SceneSpec spec =
      scene_spec(options.server, options.detection, choose_format(options.position_format, motion.is_double));
  spec.set_display_name(options.scene.name);
  spec.set_rest_distance(options.exclusions.rest_distance);
  grow_box(spec, motion);
  return spec;
}

FrameSource frames_of(Play& played) {
  const auto rigid = std::make_shared<RigidMotion>(played.motion.meshes, played.rigid);
  const auto sent = std::make_shared<int>(0);
  const auto next = [&played, rigid, sent]() -> std::optional<v1::Frame> {
    const Motion& motion = played.motion;
    if (*sent == motion.frames) return {};
    std::vector<scenes::Vec3d> positions = motion.positions(*sent);
    v1::Frame frame = make_frame(motion.meshes, static_cast<uint64_t>(++*sent), played.spec, positions);
    set_advance(played.options.detection, frame);
    if (!played.options.contacts.is_empty()) played.in_flight.push_back(positions);
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

/// Writes the contacts of each answer.
class ContactWriter {
 public:
  ContactWriter(Play& played, const std::vector<client::MeshInput>& meshes)
      : played_(played), files_(played.options.contacts) {
    if (asks_for_crossings(played.spec)) scene_.emplace(meshes);
  }
  void add(const client::FrameOutput& output) {
    std::vector<scenes::Vec3d> end = std::move(played_.in_flight.front());
    played_.in_flight.pop_front();
    files_.add(output, {last_, end, scene_ ? &*scene_ : nullptr});
    if (played_.spec.mode() != v1::DETECTION_MODE_DCD) last_ = std::move(end);
  }
  void finish() { files_.finish(); }

 private:
  Play& played_;
  ContactFiles files_;
  std::optional<client::SceneFeatures> scene_;
  std::vector<scenes::Vec3d> last_;  ///< where the next step starts; the first one stands still
};

Json input_json(const StreamOptions& options, const Motion& motion) {
  Json out = {{"name", motion.name}};
  if (motion.files.empty()) out["scale"] = options.scene.scale;
  const ContactFileNames& names = options.contacts;
  for (const auto& [key, name] : {std::pair("out", names.csv), {"vtp", names.vtp}, {"ply", names.ply}})
    if (!name.empty()) out[key] = name;
  return out;
}

/// Plays, and leaves whole files of what was sent and answered until something ends it.
void play_into_files(client::FrameStream& stream, const v1::Scene& scene, const std::vector<client::MeshInput>& meshes,
                     Play& played) {
  const StreamOptions& options = played.options;
  FrameSource source = frames_of(played);
  std::optional<RecordingWriter> recording;
  if (!options.record.empty()) record(source, recording.emplace(options.record, played.spec, meshes));
  std::optional<ContactWriter> contacts;
  PlayOptions how{.input = input_json(options, played.motion),
                  .has_lines = (!options.files.empty() || recording) && !is_standard_output(options.contacts.csv),
                  .files = played.motion.files,
                  .json = options.json,
                  .out = options.contacts.csv};
  if (!options.contacts.is_empty()) {
    contacts.emplace(played, meshes);
    how.take = [&](const client::FrameOutput& output) { contacts->add(output); };
  }
  const auto finish = [&] {
    if (recording) recording->finish();
    if (contacts) contacts->finish();
  };
  try {
    play_and_report(stream, scene, source, how);
  } catch (const std::exception&) {
    finish();
    throw;
  }
  finish();
}

void run(StreamOptions& options) {
  options.files = expand_folders(options.files);
  check_usage(options);
  check_writable("--record", options.record);
  check_files(options.detection, options.contacts);
  const Motion motion = options.files.empty() ? scene_motion(options.scene) : file_motion(options.files);
  std::vector<client::MeshInput> meshes = described_inputs(motion.meshes, options.detection);
  options.exclusions.apply_to(meshes);
  Play played{options, motion, spec_of(options, motion), {}};
  options.exclusions.exclude_meshes(played.spec, meshes);
  for (const std::string& name : options.rigid) {
    played.rigid.push_back(mesh_of(meshes, "--rigid", name));
    meshes[played.rigid.back()].is_rigid = true;
  }
  Connection connection(options.server);
  if (!options.contacts.is_empty()) connection.ask_for_all_fields(played.spec);
  const SceneGuard scene = connection.create_scene(played.spec, meshes);
  client::FrameStream stream = connection.stream(*scene);
  play_into_files(stream, *scene, meshes, played);
}

}  // namespace

void add_stream(CLI::App& app) {
  auto options = std::make_shared<StreamOptions>();
  CLI::App& command =
      *app.add_subcommand("stream", "Play mesh files or a procedural scene and tell what the frames cost");
  command
      .add_option("FRAME", options->files,
                  "Mesh files, a frame each, or folders of them, in natural order: frame2 before frame10")
      ->type_name("FILE");
  add_optional_scene_options(command, options->scene);
  add_detection_options(command, options->detection);
  add_mesh_options(command, options->detection);
  add_advance_options(command, options->detection);
  command.add_option("--rigid", options->rigid, "Meshes that move as rigid bodies, and send poses, such as ball")
      ->type_name("NAME")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_mesh_pairs_option(command, options->exclusions);
  add_ring_option(command, options->exclusions.rings);
  add_rest_options(command, options->exclusions);
  add_server_options(command, options->server);
  add_automatic_format_option(command, options->position_format);
  command.add_option("--record", options->record, "File that takes the scene and its frames, for 'collidectl replay'")
      ->type_name("FILE");
  command
      .add_option("--out", options->contacts.csv,
                  "CSV file for the contacts of all frames, or with {frame} in its name one each; -: standard output")
      ->type_name("FILE");
  command
      .add_option("--vtp", options->contacts.vtp,
                  "VTK files of contacts as points, such as contacts_{frame}.vtp, and contacts.pvd, their series")
      ->type_name("FILE");
  command.add_option("--ply", options->contacts.ply, "PLY files of contacts as points, such as contacts_{frame}.ply")
      ->type_name("FILE");
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
