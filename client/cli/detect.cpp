// collidectl detect: one step, from mesh files to contacts.

#include <cstdio>
#include <exception>
#include <memory>

#include "client/cli/commands.hpp"
#include "client/cli/daemon/connection.hpp"
#include "client/cli/input/mesh_input.hpp"
#include "client/cli/input/step_input.hpp"
#include "client/cli/options/exclusion_options.hpp"
#include "client/cli/options/options.hpp"
#include "client/cli/options/usage_error.hpp"
#include "client/cli/output/contact_files.hpp"
#include "client/cli/output/output.hpp"
#include "client/cli/report/contacts.hpp"
#include "client/cli/report/frame_line.hpp"
#include "client/cli/report/text.hpp"

namespace collided::cli {

namespace {

struct DetectOptions {
  ServerOptions server;
  DetectionOptions detection;
  ExclusionOptions exclusions;
  std::vector<std::string> frames;
  std::string position_format = kAutomaticFormat;
  std::string out, vtp, ply;
  bool json = false;
};

void check_usage(const DetectOptions& options) {
  const size_t frames = options.frames.size();
  if (options.detection.mode == "ccd" && frames != 2)
    throw UsageError("--mode ccd needs two frames, FRAME0 and FRAME1; 1 was given");
  if (options.detection.mode == "dcd" && frames != 1) throw UsageError("--mode dcd needs one frame; 2 were given");
  check_usage(options.detection);
  check_one_output(options.out, options.json);
  check_points(options.detection, "--vtp", options.vtp);
  check_points(options.detection, "--ply", options.ply);
  check_distinct({{"--out", options.out}, {"--vtp", options.vtp}, {"--ply", options.ply}});
  check_kept(options.frames, {{"--out", options.out}, {"--vtp", options.vtp}, {"--ply", options.ply}});
}

StepInput read_step(const DetectOptions& options) {
  const std::vector<std::string>& frames = options.frames;
  return frames.size() == 2 ? file_step(frames[0], frames[1]) : file_frame(frames[0]);
}

void print(const DetectOptions& options, const Json& summary) {
  if (options.json)
    std::printf("%s\n", json_text(summary).c_str());
  else
    print_summary(options.out, report_text(summary));
}

using WriteContacts = void (*)(const std::string&, const client::FrameOutput&, const StepPositions&);

/// Prints the result even if its files cannot be written.
void report(const DetectOptions& options, Json summary, const client::FrameOutput& output, const StepInput& step) {
  std::exception_ptr failure;
  const auto write = [&](const char* name, const std::string& file, WriteContacts write_contacts) {
    if (file.empty()) return;
    if (const auto why = failure_in([&] { write_contacts(file, output, {step.start, step.end}); }))
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

void run(const DetectOptions& options) {
  check_usage(options);
  check_writable("--out", options.out);
  check_writable("--vtp", options.vtp);
  check_writable("--ply", options.ply);
  const StepInput step = read_step(options);
  std::vector<client::MeshInput> meshes = mesh_inputs(step.meshes);
  options.exclusions.apply_to(meshes);
  v1::SceneSpec spec =
      scene_spec(options.server, options.detection, choose_format(options.position_format, step.is_double));
  if (has_files(options)) ask_for_all_fields(spec);
  grow_box(spec, step.start);
  grow_box(spec, step.end);
  v1::Frame frame = step_frame(step, 1, spec);
  frame.set_advance(options.detection.advance);
  Connection connection(options.server);
  const SceneGuard scene = connection.create_scene(spec, meshes);
  client::FrameStream stream = connection.stream(*scene);
  const client::FrameOutput output = run_frame(stream, frame);
  stream.finish();
  Json summary = {{"scene", scene_json(*scene)}};
  summary.update(found_json(output.done, spec));
  if (const auto contact = earliest_contact(output)) summary["earliest"] = *contact;
  summary.update(frame_json(output.done, spec.report()));
  summary.update(transport_json(stream));
  report(options, std::move(summary), output, step);
}

}  // namespace

void add_detect(CLI::App& app) {
  auto options = std::make_shared<DetectOptions>();
  CLI::App& command = *app.add_subcommand("detect", "Contacts of one step between mesh files");
  command.add_option("FRAME", options->frames, "OBJ or PLY: FRAME0 FRAME1 for ccd, one for dcd")
      ->type_name("FILE")
      ->required()
      ->expected(1, 2);
  add_detection_options(command, options->detection);
  add_advance_options(command, options->detection);
  add_ring_option(command, options->exclusions.rings);
  add_server_options(command, options->server);
  add_automatic_format_option(command, options->position_format);
  command
      .add_option("--out", options->out,
                  "CSV file for the contacts, their weights, points and normals; -: standard output")
      ->type_name("FILE");
  command.add_option("--vtp", options->vtp, "VTK file (PolyData) with a point for each contact, for ParaView")
      ->type_name("FILE");
  command.add_option("--ply", options->ply, "PLY file with a point for each contact")->type_name("FILE");
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
