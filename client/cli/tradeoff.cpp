// collidectl tradeoff: time against accuracy, measured on one step against ground truth.

#include <cstdio>
#include <exception>
#include <memory>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/options/finite.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/cli/commands.hpp"
#include "client/measure/tradeoff/report.hpp"
#include "client/measure/tradeoff/result_json.hpp"
#include "client/measure/tradeoff/run.hpp"

namespace collided::cli {

namespace {

struct TradeoffOptions {
  TradeoffSettings settings;
  SceneOptions scene;
  std::vector<std::string> frames;
  std::string out, date, commit;
  bool json = false;
};

void check_usage(const TradeoffOptions& options) {
  if (options.scene.name.empty() == options.frames.empty())
    throw UsageError("tradeoff needs one of FRAME0 FRAME1 and --scene");
  if (options.frames.size() == 1) throw UsageError("tradeoff needs two frames, FRAME0 and FRAME1; 1 was given");
  if (!options.settings.truth.empty() && options.frames.empty())
    throw UsageError("--truth needs FRAME0 FRAME1, whose positions it is the truth of");
  if (!options.settings.truth.empty() && options.settings.detection.thickness != 0)
    throw UsageError("--truth is for thickness 0 and cannot judge --thickness");
  check_runs(options.settings);
}

std::string json_file(const TradeoffOptions& options) { return options.out + "/tradeoff.json"; }
std::string table_file(const TradeoffOptions& options) { return options.out + "/tradeoff.md"; }

void check_outputs(const TradeoffOptions& options) {
  make_folder("--out", options.out);
  for (const std::string& file : {json_file(options), table_file(options)}) check_writable("--out", file);
}

void write_files(const TradeoffOptions& options, const Tradeoff& result) {
  write_text(json_file(options), json_lines(tradeoff_json(result)));
  write_text(table_file(options), tradeoff_markdown(result));
}

void print_report(const TradeoffOptions& options, const Tradeoff& result) {
  const Json summary = {{"out", options.out}, {"results", Json::array({tradeoff_summary(result)})}};
  if (options.json)
    std::printf("%s\n", json_text(summary).c_str());
  else
    std::printf("%sResult and table: %s\n", tradeoff_text(result).c_str(), options.out.c_str());
}

/// After an interrupt the position formats finished so far are reported; so is a result whose files cannot be written.
void run(const TradeoffOptions& options) {
  check_usage(options);
  check_outputs(options);
  const StepInput step =
      options.frames.empty() ? scene_step(options.scene) : file_step(options.frames[0], options.frames[1]);
  Tradeoff result;
  result.date = options.date;
  result.commit = options.commit;
  std::exception_ptr interrupted;
  try {
    measure(options.settings, step, result);
  } catch (const Interrupted&) {
    if (result.runs.empty()) throw;
    interrupted = std::current_exception();
  }
  const std::exception_ptr failure = failure_in([&] { write_files(options, result); });
  print_report(options, result);
  if (failure) std::rethrow_exception(failure);
  if (interrupted) std::rethrow_exception(interrupted);
}

void add_input_options(CLI::App& command, TradeoffOptions& options) {
  command.add_option("FRAME", options.frames, "Mesh files: FRAME0 FRAME1, the start and the end of the step")
      ->type_name("FILE")
      ->expected(1, 2);
  add_scene_options(command, options.scene);
  command.remove_option(command.get_option("--frames"));
  CLI::Option* scene = command.get_option("--scene")->required(false);
  for (const char* name : {"--t0", "--dt", "--scale"}) command.get_option(name)->needs(scene);
  command
      .add_option("--truth", options.settings.truth,
                  "Folder with vf.csv (vertex,triangle,collides,toi) and ee.csv (a0,a1,b0,b1,collides,toi) for FRAME0 "
                  "FRAME1; judges float positions only if every position is one. Default: the level exact")
      ->type_name("FOLDER");
}

void add_run_options(CLI::App& command, TradeoffSettings& settings) {
  command.add_option("--levels", settings.levels, "Accuracy levels: fast, guarded, certified, exact")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"fast", "guarded", "certified", "exact"}))
      ->capture_default_str();
  command.add_option("--deltas", settings.deltas, "Tolerances of the levels from guarded on; 0: the daemon's choice")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(finite())
      ->check(at_least_zero())
      ->capture_default_str();
  command.add_option("--formats", settings.formats, "Positions on the wire: f32, f64, q16 (not with exact)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(position_formats()))
      ->capture_default_str();
  command.add_option("--repeats", settings.repeats, "Measured steps, whose median counts, after one warm-up step")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command.add_option("--mode", settings.detection.mode, "ccd: between two frames")
      ->check(CLI::IsMember({"ccd"}))
      ->capture_default_str();
  command.add_option("--thickness", settings.detection.thickness, "Contact distance, in the unit of the positions")
      ->check(finite())
      ->check(at_least_zero())
      ->capture_default_str();
}

}  // namespace

void add_tradeoff(CLI::App& app) {
  auto options = std::make_shared<TradeoffOptions>();
  CLI::App& command = *app.add_subcommand("tradeoff", "Measure time against accuracy: levels, deltas, formats");
  command.footer(
      "Writes tradeoff.json and tradeoff.md; client/measure/plot, in the sources, draws tradeoff.json. Without\n"
      "--truth the level exact is the judge: it decides in exact arithmetic on each format's own positions.");
  add_input_options(command, *options);
  add_run_options(command, options->settings);
  add_server_options(command, options->settings.server);
  command.add_option("--out", options->out, "Folder; created if missing")->type_name("FOLDER")->required();
  command.add_option("--date", options->date, "Recorded in the result")->type_name("DATE");
  command.add_option("--commit", options->commit, "Recorded in the result")->type_name("COMMIT");
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
