// collidectl bench: the engine's time for the steps of scenes, without network, upload and download; or, with
// --end-to-end, the time of whole frames.

#include <exception>
#include <memory>

#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/cli/commands.hpp"
#include "client/cpp/positions.hpp"
#include "client/measure/bench/output.hpp"
#include "client/measure/bench/run.hpp"
#include "client/measure/end_to_end/run.hpp"

namespace collided::cli {

namespace {

struct BenchOptions {
  BenchSettings settings;
  std::vector<std::string> scenes, frames, engines{"auto"};
  double scale = 1;
  bool end_to_end = false;
  std::vector<double> megabytes{1, 5};
  std::string out;
  bool json = false;
};

void check_end_to_end(const BenchOptions& options) {
  if (options.scenes.size() > 1 || options.engines.size() > 1)
    throw UsageError("--end-to-end takes one --scene and one --engine");
  if (client::is_quantized(format_of(options.settings.position_format)))
    throw UsageError("--end-to-end takes --position-format f32 or f64");
  check_usage(options.settings.detection);
}

void check_usage(const BenchOptions& options) {
  check_one_output(options.out, options.json);
  if (options.end_to_end) return check_end_to_end(options);
  if (options.scenes.empty() == options.frames.empty()) throw UsageError("bench needs one of --scene and --frames");
  const std::string& mode = options.settings.detection.mode;
  if (mode == "ccd" && options.frames.size() == 1)
    throw UsageError("--mode ccd needs two frames, --frames FRAME0 FRAME1; 1 was given");
  if (mode == "dcd" && options.frames.size() == 2)
    throw UsageError("--mode dcd needs one frame, --frames FRAME; 2 were given");
  check_usage(options.settings.detection);
}

void check_work(const BenchOptions& options) {
  for (const std::string& name : options.scenes) scenes::check_scene(name, options.scale);
  check_writable("--out", options.out);
}

class Bench {
 public:
  explicit Bench(const BenchOptions& options)
      : options_(options), connection_(options.settings.server), output_(options.out, options.json) {
    output_.show(bench_head());
  }

  void run(const BenchInput& input) {
    BenchSettings settings = options_.settings;
    for (const std::string& engine : options_.engines) {
      settings.detection.engine = engine;
      const BenchRun run = measure(connection_, settings, input);
      if (!run.steps.empty()) add(run);
      if (run.interrupted) std::rethrow_exception(run.interrupted);
    }
  }
  void finish() const { output_.finish(); }

 private:
  void add(const BenchRun& run) {
    runs_.push_back(run);
    output_.show(bench_lines(run_json(run)));
    const Json scale = options_.frames.empty() ? Json(options_.scale) : Json(nullptr);
    output_.keep(bench_json(runs_, options_.settings.warm_up, scale));
  }

  const BenchOptions& options_;
  Connection connection_;
  BenchOutput output_;
  std::vector<BenchRun> runs_;
};

void run_whole_frames(const BenchOptions& options) {
  EndToEndOptions out{.settings = options.settings,
                      .scale = options.scale,
                      .megabytes = options.megabytes,
                      .out = options.out,
                      .json = options.json};
  if (!options.scenes.empty()) out.scene = options.scenes.front();
  out.settings.detection.engine = options.engines.front();
  run_end_to_end(out);
}

/// If it ends early, the runs so far are kept.
void run_steps(const BenchOptions& options) {
  std::optional<BenchInput> files;
  if (!options.frames.empty()) files = file_input(options.frames);
  Bench bench(options);
  try {
    if (files) bench.run(*files);
    for (const std::string& name : options.scenes) bench.run(scene_input(name, options.scale));
  } catch (const std::exception&) {
    bench.finish();
    throw;
  }
  bench.finish();
}

void run(const BenchOptions& options) {
  check_usage(options);
  check_work(options);
  if (options.end_to_end) return run_whole_frames(options);
  run_steps(options);
}

void add_input_options(CLI::App& command, BenchOptions& options) {
  command.add_option("--scene", options.scenes, "Procedural scenes, see 'collidectl scenes', such as funnel,nbody")
      ->type_name("SCENE")
      ->check(known_scene())
      ->delimiter(',')
      ->allow_extra_args(false);
  add_scale_option(command, options.scale);
  command.add_option("--frames", options.frames, "Mesh files: FRAME0 FRAME1 for ccd, one for dcd, the same each step")
      ->type_name("FILE")
      ->expected(1, 2)
      ->excludes(command.get_option("--scale"));
}

void add_step_options(CLI::App& command, BenchSettings& settings) {
  command.add_option("--steps", settings.steps, "Measured steps; a scene goes from t = 0 to 1 in that many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command.add_option("--warm-up", settings.warm_up, "Steps before these, spread over the motion, while buffers grow")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
}

void add_end_to_end_options(CLI::App& command, BenchOptions& options) {
  CLI::Option* whole = command.add_flag("--end-to-end", options.end_to_end,
                                        "Whole frames instead, over every transport of its own daemon (cloth_ball)");
  whole->excludes(command.get_option("--server"))->excludes(command.get_option("--frames"));
  command
      .add_option("--megabytes", options.megabytes,
                  "Further scales, each with about this many MB of positions per frame")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(finite())
      ->check(CLI::Range(0.01, 1000.0))
      ->needs(whole)
      ->default_str("1,5");
}

}  // namespace

void add_bench(CLI::App& app) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App& command = *app.add_subcommand("bench", "Measure the engine's time for the steps of scenes");
  command.footer(
      "Times are the engine's own, from positions on the backend to contacts in canonical order there: no network,\n"
      "upload or download. Counts are those of the last step. With --end-to-end a frame's time runs from positions in "
      "the\n"
      "client's memory to contacts there, alternating with the same bytes over bare sockets; overhead is that time "
      "less the\n"
      "engine's, 'to bare' its ratio to loopback TCP, 'to held' the same at the pace of the frames.");
  add_input_options(command, *options);
  add_step_options(command, options->settings);
  add_detection_options(command, options->settings.detection);
  command.remove_option(command.get_option("--engine"));
  add_engines_option(command, options->engines);
  add_position_format_option(command, options->settings.position_format);
  add_server_options(command, options->settings.server);
  add_end_to_end_options(command, *options);
  command.add_option("--out", options->out, "JSON file for all runs, written after each; -: standard output")
      ->type_name("FILE");
  command.add_flag("--json", options->json, "Print all runs as one JSON object instead of the table");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
