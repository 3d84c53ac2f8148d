// collidectl detect: whether meshes touch or intersect themselves, or what one step between two frames of a mesh finds.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/frame_files.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/input/step_input.hpp"
#include "client/app/options/exclusion_options.hpp"
#include "client/app/options/mesh_options.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/contact_files.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/contacts.hpp"
#include "client/app/report/frame_line.hpp"
#include "client/app/report/outcome.hpp"
#include "client/app/report/text.hpp"
#include "client/app/report/touching.hpp"
#include "client/cli/commands.hpp"
#include "client/cli/intersection/self_intersection.hpp"

namespace collided::cli {

namespace {

struct DetectOptions {
  ServerOptions server;
  DetectionOptions detection;
  ExclusionOptions exclusions;
  std::vector<std::string> meshes;  ///< files of meshes that stand still
  std::vector<std::string> frames;  ///< files of one mesh
  std::string position_format = kAutomaticFormat;
  std::string out, vtp, ply;
  bool has_chosen_kinds = false;   ///< the command did, not the user
  bool has_self_contacts = false;  ///< also with several meshes; and whether they intersect themselves
  bool is_kept = false;            ///< leaves out contacts that others cover
  bool json = false;
};

std::vector<std::string> inputs_of(const DetectOptions& options) {
  return options.meshes.empty() ? options.frames : options.meshes;
}

/// A folder has the frames of one mesh. A single frame is a mesh that stands still, however it is named.
void find_frames(DetectOptions& options) {
  const auto is_folder = [](const std::string& name) { return std::filesystem::is_directory(name); };
  if (options.meshes.size() == 1 && is_folder(options.meshes[0])) options.frames = std::exchange(options.meshes, {});
  for (const std::string& mesh : options.meshes)
    if (is_folder(mesh)) throw UsageError(mesh + " is a folder, whose files are frames of one mesh; it goes alone");
  options.frames = expand_folders(options.frames);
  if (options.meshes.empty() && options.frames.size() == 1) options.meshes = std::exchange(options.frames, {});
}

/// Fills in what the user did not choose. Two frames have motion. Meshes that stand still are tested exactly, and what
/// goes through each other counts as well.
void choose_detection(const CLI::App& command, DetectOptions& options) {
  const auto is_given = [&](const char* option) { return command.get_option(option)->count() > 0; };
  DetectionOptions& detection = options.detection;
  if (!is_given("--mode")) detection.mode = options.frames.size() == 2 || options.detection.advance ? "ccd" : "dcd";
  if (options.meshes.empty() || detection.mode == "ccd") return;
  if (!is_given("--accuracy")) detection.accuracy = "exact";
  options.has_chosen_kinds = !is_given("--kinds") && detection.accuracy == "exact";
  if (options.has_chosen_kinds) detection.kinds = {"vt", "ee", "tt", "et"};
}

/// Refuses --kept where the daemon does not find out which contacts are covered.
void check_kept_contacts(const DetectOptions& options) {
  const DetectionOptions& detection = options.detection;
  const auto has = [&](const char* kind) { return std::ranges::count(detection.kinds, kind) > 0; };
  if (detection.mode != "dcd" || detection.accuracy == "candidates" || detection.report != "all" || !has("vt") ||
      !has("ee") || !options.server.part_devices.empty())
    throw UsageError(
        "--kept needs --mode dcd, --accuracy fast, guarded, certified or exact, --report all, the kinds vt and ee, and "
        "one device");
}

void check_usage(const DetectOptions& options) {
  if (options.meshes.empty() == options.frames.empty()) throw UsageError("detect needs one of MESH... and --frames");
  const size_t frames = options.frames.size();
  const std::string& mode = options.detection.mode;
  if (frames > 2)
    throw UsageError("detect takes one step, of two frames; there are " + std::to_string(frames) +
                     ": 'collidectl stream' plays them");
  if (mode == "ccd" && frames != 2)
    throw UsageError("--mode ccd needs two frames, --frames FRAME0 FRAME1; what was given stands still");
  if (mode == "dcd" && frames == 2) throw UsageError("--mode dcd needs one frame; 2 were given");
  if (options.has_self_contacts && frames == 2)
    throw UsageError("--self tests meshes that stand still; two frames move");
  check_usage(options.detection);
  if (options.is_kept) check_kept_contacts(options);
  check_one_output(options.out, options.json);
  DetectionOptions located =
      options.detection;  // files of points leave out what has none, unless it is all that is asked
  if (options.has_chosen_kinds) located.kinds = {"vt", "ee", "et"};
  check_points(located, "--vtp", options.vtp);
  check_points(located, "--ply", options.ply);
  check_distinct({{"--out", options.out}, {"--vtp", options.vtp}, {"--ply", options.ply}});
  check_kept(inputs_of(options), {{"--out", options.out}, {"--vtp", options.vtp}, {"--ply", options.ply}});
}

StepInput read_step(const DetectOptions& options) {
  return options.meshes.empty() ? file_step(options.frames[0], options.frames[1]) : file_meshes(options.meshes);
}

/// Prints sentences first, then the figures.
std::string text_of(Json summary) {
  std::string text = summary["found"].get<std::string>() + "\n";
  if (summary.contains("notes"))
    for (const Json& note : summary["notes"]) text += note.get<std::string>() + "\n";
  summary.erase("found"), summary.erase("notes"), summary.erase("touching");
  summary.erase("self_intersections");
  return text + "\n" + report_text(summary);
}

void print(const DetectOptions& options, const Json& summary) {
  if (options.json)
    std::printf("%s\n", json_text(summary).c_str());
  else
    print_summary(options.out, text_of(summary));
}

using WriteContacts = void (*)(const std::string&, const client::FrameOutput&, const StepPositions&);

/// Prints the result even if its files cannot be written.
void report(const DetectOptions& options, Json summary, const client::FrameOutput& output,
            const StepPositions& positions) {
  std::exception_ptr failure;
  const auto write = [&](const char* name, const std::string& file, WriteContacts write_contacts) {
    if (file.empty()) return;
    if (const auto why = failure_in([&] { write_contacts(file, output, positions); }))
      failure = why;
    else
      summary[name] = file;
  };
  write("out", options.out, write_csv);
  write("vtp", options.vtp, write_vtp);
  write("ply", options.ply, write_ply);
  print(options, summary);
  if (failure) std::rethrow_exception(failure);
}

bool has_files(const DetectOptions& options) {
  return !options.out.empty() || !options.vtp.empty() || !options.ply.empty();
}

/// Judges one mesh in a scene of its own, whatever the options say of contacts.
SelfIntersection check_self(Connection& connection, const DetectOptions& options, const scenes::Mesh& mesh,
                            client::Positions positions, bool is_double) {
  v1::SceneSpec spec = scene_spec(options.server, self_detection(), choose_format(kAutomaticFormat, is_double));
  connection.ask_for_all_fields(spec);
  const std::vector<scenes::Mesh> alone{mesh};
  const std::vector<client::MeshInput> inputs = mesh_inputs(alone);
  const SceneGuard scene = connection.create_scene(spec, inputs);
  client::FrameStream stream = connection.stream(*scene);
  const client::FrameOutput output = run_frame(stream, make_frame(alone, 1, spec, positions));
  stream.finish();
  return judge_self(inputs[0], positions, output);
}

/// Judges meshes that stand still: all of them with --self, else one alone if its contacts tell.
std::vector<SelfIntersection> check_selves(Connection& connection, const DetectOptions& options, const StepInput& step,
                                           const std::vector<client::MeshInput>& meshes,
                                           const client::FrameOutput& output, const v1::SceneSpec& spec) {
  const bool is_rounded = spec.position_format() != choose_format(kAutomaticFormat, step.is_double);
  if (meshes.size() == 1 && !is_rounded && tells_self_intersection(spec, meshes[0]))
    return {judge_self(meshes[0], step.end, output)};
  std::vector<SelfIntersection> selves;
  size_t first = 0;
  for (const scenes::Mesh& mesh : step.meshes) {
    if (!options.has_self_contacts) break;
    const client::Positions positions = client::Positions(step.end).subspan(first, mesh.vertex_count);
    selves.push_back(check_self(connection, options, mesh, positions, step.is_double));
    first += mesh.vertex_count;
  }
  return selves;
}

/// Says in sentences what was found. The verdict on one mesh alone is the whole answer.
Json found_in_words(const Touching& touching, const std::vector<SelfIntersection>& selves) {
  std::string text = selves.size() == 1 && touching.meshes.size() == 1 ? "" : touching_text(touching);
  for (const SelfIntersection& self : selves) text += (text.empty() ? "" : "\n") + self_text(self);
  Json out = {{"found", text}, {"touching", touching_json(touching)}};
  if (!selves.empty()) out["self_intersections"] = Json::array();
  for (const SelfIntersection& self : selves) out["self_intersections"].push_back(self_json(self));
  return out;
}

/// Throws DoneBut for meshes that were to be free of self-intersection, and are not for sure.
void check_free(const std::vector<SelfIntersection>& selves) {
  const auto others = std::ranges::count_if(selves, [](const SelfIntersection& self) { return !self.is_free(); });
  if (others > 0)
    throw DoneBut(std::to_string(others) + " of " + std::to_string(selves.size()) +
                  " meshes not shown to be free of self-intersection; the report says why");
}

void run(const DetectOptions& options) {
  check_usage(options);
  check_writable("--out", options.out);
  check_writable("--vtp", options.vtp);
  check_writable("--ply", options.ply);
  const StepInput step = read_step(options);
  std::vector<client::MeshInput> meshes = described_inputs(step.meshes, options.detection);
  options.exclusions.apply_to(meshes);
  for (client::MeshInput& mesh : meshes) mesh.no_self_contacts = meshes.size() > 1 && !options.has_self_contacts;
  v1::SceneSpec spec =
      scene_spec(options.server, options.detection, choose_format(options.position_format, step.is_double));
  const bool stands_still = step.start.empty();
  grow_box(spec, step.start);
  grow_box(spec, step.end);
  v1::Frame frame = step_frame(step, 1, spec);
  set_advance(options.detection, frame);
  Connection connection(options.server);
  if (has_files(options) || options.is_kept || stands_still)
    connection.ask_for_all_fields(spec);  // which say where meshes meet
  if (has_solids(options.detection) && options.detection.report == "all")
    spec.add_fields(v1::CONTACT_FIELD_PAIR_STATES);
  if (options.is_kept && std::ranges::count(spec.fields(), int{v1::CONTACT_FIELD_FEATURES}) == 0)
    spec.add_fields(v1::CONTACT_FIELD_FEATURES);  // an older daemon is refused, rather than nothing left out
  const SceneGuard scene = connection.create_scene(spec, meshes);
  client::FrameStream stream = connection.stream(*scene);
  client::FrameOutput output = run_frame(stream, frame);
  stream.finish();
  const std::optional<uint64_t> covered = count_covered(output);
  const client::SceneFeatures features(stands_still ? meshes : std::vector<client::MeshInput>{});
  const Touching touching{meshes, step.end, output, spec, features};
  std::vector<SelfIntersection> selves;
  if (stands_still) selves = check_selves(connection, options, step, meshes, output, spec);
  if (options.is_kept) leave_out_covered(output);  // verdicts are of all
  Json summary = stands_still ? found_in_words(touching, selves) : Json{{"found", step_text(step.name, touching)}};
  if (!step.notes.empty()) summary["notes"] = step.notes;
  summary["scene"] = scene_json(*scene);
  summary.update(found_json(output.done, spec));
  if (covered) summary["covered_count"] = *covered;
  summary.update(advance_json(output));
  if (const auto contact = earliest_contact(output)) summary["earliest"] = *contact;
  summary.update(frame_json(output.done, spec.report()));
  summary.update(transport_json(stream));
  report(options, std::move(summary), output, {step.start, step.end, asks_for_crossings(spec) ? &features : nullptr});
  if (options.has_self_contacts) check_free(selves);
}

}  // namespace

void add_detect(CLI::App& app) {
  auto options = std::make_shared<DetectOptions>();
  CLI::App& command = *app.add_subcommand("detect", "Whether meshes touch, and contacts of one step");
  command.footer(
      "Several meshes are tested against each other as they stand, one mesh against itself. A folder has the frames\n"
      "of one mesh, as --frames does; one frame alone stands still, as a MESH does.\n"
      "\n"
      "  collidectl detect ball.ply box.obj\n"
      "  collidectl detect --self body.stl && echo free of self-intersection\n"
      "  collidectl detect ball.ply box.obj --thickness 0.01 --out contacts.csv\n"
      "  collidectl detect --solid part.stl housing.stl\n"
      "  collidectl detect --frames before.ply after.ply\n"
      "\n"
      "Exit codes: 0 done, 1 failure, 2 bad usage, 3 done, but with --self a mesh is not free of self-intersection, "
      "128 + n interrupted by signal n.");
  command.add_option("MESH", options->meshes, "Meshes of one scene: OBJ, PLY, STL, OFF, glTF, GLB or DAE")
      ->type_name("FILE");
  command
      .add_option("--frames", options->frames,
                  "FRAME0 FRAME1 of one mesh: what touches as it moves from one to the other")
      ->type_name("FILE")
      ->expected(1, 2);
  command.add_flag(
      "--self", options->has_self_contacts,
      "Tell whether each mesh is free of self-intersection, decided exactly; of several meshes, contacts of each with "
      "itself count, too");
  command.add_flag("--kept", options->is_kept,
                   "List only contacts that no other one covers, one for each local minimum of distance (dcd)");
  add_detection_options(command, options->detection);
  add_mesh_options(command, options->detection);
  add_advance_options(command, options->detection);
  add_ring_option(command, options->exclusions.rings);
  add_server_options(command, options->server);
  add_automatic_format_option(command, options->position_format);
  command
      .add_option("--out", options->out,
                  "CSV file for the contacts, their weights, points and normals; -: standard output")
      ->type_name("FILE");
  command
      .add_option("--vtp", options->vtp,
                  "VTK file (PolyData) with a point for each contact and a line for each contour, for ParaView")
      ->type_name("FILE");
  command.add_option("--ply", options->ply, "PLY file with a point for each contact, and edges along contours")
      ->type_name("FILE");
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.get_option("--mode")->default_str("ccd with two frames, else dcd");
  command.get_option("--accuracy")->default_str("exact for what stands still, certified for two frames");
  command.get_option("--kinds")->default_str("vt,ee,tt,et for what stands still, vt,ee for two frames");
  command.callback([options, &command] {
    find_frames(*options);
    choose_detection(command, *options);
    run(*options);
  });
}

}  // namespace collided::cli
