// collidectl detect: one step, from mesh files to contacts.

#include <cstdio>
#include <exception>
#include <memory>

#include "client/cli/commands.hpp"
#include "client/cli/daemon/connection.hpp"
#include "client/cli/input/mesh_input.hpp"
#include "client/cli/options/exclusion_options.hpp"
#include "client/cli/options/options.hpp"
#include "client/cli/options/usage_error.hpp"
#include "client/cli/output/csv.hpp"
#include "client/cli/output/output.hpp"
#include "client/cli/report/contacts.hpp"
#include "client/cli/report/json.hpp"
#include "client/cli/report/text.hpp"
#include "client/scenes/mesh_files/mesh_file.hpp"

namespace collided::cli {

namespace {

constexpr const char* kAutomatic = "auto";

struct DetectOptions {
  ServerOptions server;
  DetectionOptions detection;
  ExclusionOptions exclusions;
  std::vector<std::string> frames;
  std::string position_format = kAutomatic;
  std::string out;
  bool json = false;
};

void check_usage(const DetectOptions& options) {
  const size_t frames = options.frames.size();
  if (options.detection.mode == "ccd" && frames != 2)
    throw UsageError("--mode ccd needs two frames, FRAME0 and FRAME1; 1 was given");
  if (options.detection.mode == "dcd" && frames != 1) throw UsageError("--mode dcd needs one frame; 2 were given");
  check_usage(options.detection);
  check_one_output(options.out, options.json);
}

void check_count(const DetectOptions& options, const char* what, size_t a, size_t b) {
  if (a != b)
    throw std::runtime_error("the frames differ: " + options.frames[0] + " has " + std::to_string(a) + " " + what +
                             ", " + options.frames[1] + " has " + std::to_string(b));
}

std::vector<scenes::MeshFile> read_frames(const DetectOptions& options) {
  std::vector<scenes::MeshFile> frames;
  for (const std::string& file : options.frames) frames.push_back(scenes::read_mesh(file));
  for (const scenes::MeshFile& frame : frames) {
    check_count(options, "vertices", frames[0].positions.size(), frame.positions.size());
    check_count(options, "triangles", frames[0].triangles.size(), frame.triangles.size());
  }
  const auto& a = frames.front().triangles;
  const auto& b = frames.back().triangles;
  for (size_t t = 0; t < a.size(); ++t)
    if (a[t] != b[t])
      throw std::runtime_error("the frames differ: of " + std::to_string(a.size()) + " and " +
                               std::to_string(b.size()) + " triangles, triangle " + std::to_string(t) +
                               " has other vertices in " + options.frames[1]);
  if (frames.front().edges != frames.back().edges || frames.front().points != frames.back().points)
    throw std::runtime_error("the frames differ: " + options.frames[1] + " has other loose edges or points than " +
                             options.frames[0]);
  return frames;
}

/// auto: F64 if a position is not exactly a float, so that nothing is rounded.
v1::PositionFormat choose_format(const std::string& wanted, const std::vector<scenes::MeshFile>& frames) {
  if (wanted != kAutomatic) return format_of(wanted);
  for (const scenes::MeshFile& frame : frames)
    if (frame.is_double) return v1::POSITION_FORMAT_F64;
  return v1::POSITION_FORMAT_F32;
}

Json contacts_json(const DetectOptions& options, const client::FrameOutput& output) {
  const bool is_counted = options.detection.report != "any";
  const bool has_times = is_counted && options.detection.mode == "ccd" && options.detection.accuracy != "candidates";
  Json out = {{"contact_count", is_counted ? Json(output.done.contact_count()) : Json(nullptr)},
              {"any_contact", output.done.any_contact()}};
  if (has_times) out["earliest_toi"] = output.done.earliest_toi();
  if (output.done.has_advanced()) out["advanced"] = output.done.advanced();
  if (const auto contact = earliest_contact(output)) out["earliest"] = *contact;
  return out;
}

void print(const DetectOptions& options, const Json& summary) {
  if (options.json)
    std::printf("%s\n", summary.dump().c_str());
  else
    print_summary(options.out, report_text(summary));
}

/// Prints the result even if its file cannot be written.
void report(const DetectOptions& options, Json summary, const client::FrameOutput& output) {
  std::exception_ptr failure;
  if (!options.out.empty()) try {
      write_csv(options.out, output);
      summary["out"] = options.out;
    } catch (const std::runtime_error&) {
      failure = std::current_exception();
    }
  print(options, summary);
  if (failure) std::rethrow_exception(failure);
}

void run(const DetectOptions& options) {
  check_usage(options);
  check_writable("--out", options.out);
  const std::vector<scenes::MeshFile> frames = read_frames(options);
  const v1::PositionFormat format = choose_format(options.position_format, frames);
  std::vector<client::MeshInput> meshes{{.name = "mesh",
                                         .vertex_count = static_cast<uint32_t>(frames[0].positions.size()),
                                         .triangles = frames[0].triangles,
                                         .edges = frames[0].edges,
                                         .points = frames[0].points}};
  options.exclusions.apply_to(meshes);
  v1::Frame frame;
  v1::SceneSpec spec = scene_spec(options.server, options.detection, format);
  for (const scenes::MeshFile& mesh : frames) grow_box(spec, mesh.positions);
  frame.set_frame_id(1);
  frame.set_advance(options.detection.advance);
  *frame.add_updates() = frames.size() == 2 ? update_of(0, spec, frames[1].positions, frames[0].positions)
                                            : update_of(0, spec, frames[0].positions);
  Connection connection(options.server);
  const SceneGuard scene = connection.create_scene(spec, meshes);
  client::FrameStream stream = connection.stream(*scene);
  const client::FrameOutput output = run_frame(stream, frame);
  stream.finish();
  Json summary = {{"scene", scene_json(*scene)}};
  summary.update(contacts_json(options, output));
  summary.update(frame_json(output.done, spec.report()));
  summary.update(transport_json(stream));
  report(options, std::move(summary), output);
}

}  // namespace

void add_detect(CLI::App& app) {
  auto options = std::make_shared<DetectOptions>();
  CLI::App& command = *app.add_subcommand("detect", "Contacts of one step between mesh files");
  command.add_option("FRAME", options->frames, "OBJ or PLY: FRAME0 FRAME1 for ccd, one for dcd")
      ->required()
      ->expected(1, 2);
  add_detection_options(command, options->detection);
  add_advance_options(command, options->detection);
  add_ring_option(command, options->exclusions);
  add_server_options(command, options->server);
  std::vector<std::string> formats = position_formats();
  formats.insert(formats.begin(), kAutomatic);
  command.add_option("--position-format", options->position_format, "auto: f64 if a position is not exactly a float")
      ->check(CLI::IsMember(formats))
      ->capture_default_str();
  command.add_option("--out", options->out, "CSV file for the contacts; -: standard output");
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
