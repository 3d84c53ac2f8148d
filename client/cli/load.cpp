// collidectl load: a load tester. Many streams send frames when they are due, and the latency of each frame is
// reported.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>

#include "client/app/options/options.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/cli/commands.hpp"
#include "client/measure/load/run.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

namespace {

using load::LoadSettings;

constexpr uint64_t kMaxStreams = 100000;

struct LoadOptions {
  LoadSettings settings;
  double rate = 0, seconds = 10, p99_ms = 0;
  std::string ramp, arrivals = "fixed", delivery = "lossless";
  bool is_closed = false, is_search = false;
};

void check_pace(const LoadOptions& options) {
  const int ways = (options.rate > 0) + !options.ramp.empty() + options.is_closed + options.is_search;
  if (ways != 1) throw UsageError("load needs one of --rate, --ramp, --closed-loop and --find-max");
  if (options.is_search != (options.p99_ms > 0))
    throw UsageError("--find-max and --p99 TIME go together, such as --find-max --p99 5ms");
  if (options.is_search && options.settings.streams.generations > 1)
    throw UsageError("--generations goes with --rate, --ramp or --closed-loop, not with --find-max");
}

void check_input(const LoadSettings& settings) {
  if (settings.input.scene.empty() == settings.input.files.empty())
    throw UsageError("load needs one of --scene and --frames");
  if (settings.detection.mode == "ccd" && settings.input.files.size() == 1)
    throw UsageError("--mode ccd needs two frames or more; 1 was given");
  check_usage(settings.detection);
  if (!settings.input.scene.empty()) scenes::check_scene(settings.input.scene, settings.input.scale);
}

void check_count(const load::StreamSettings& streams) {
  if (uint64_t{streams.clients} * streams.scenes > kMaxStreams)
    throw UsageError("--clients times --scenes is at most " + std::to_string(kMaxStreams));
}

void check_outputs(const LoadSettings& settings) {
  check_one_output(settings.out, settings.json);
  if (is_standard_output(settings.html)) throw UsageError("--html is a file; standard output (-) is none");
  check_distinct({{"--out", settings.out}, {"--html", settings.html}});
  check_writable("--out", settings.out);
  check_writable("--html", settings.html);
}

void run(const LoadOptions& options) {
  LoadSettings settings = options.settings;
  check_pace(options);
  check_input(settings);
  check_count(settings.streams);
  settings.pace.arrivals = options.arrivals == "poisson" ? load::Arrivals::kPoisson : load::Arrivals::kFixed;
  settings.pace.seconds = options.seconds;
  if (options.rate > 0) settings.pace.profile.emplace(options.rate, options.seconds);
  if (!options.ramp.empty()) settings.pace.profile.emplace(load::parse_ramp("--ramp", options.ramp));
  settings.find_max.p99_ms = options.p99_ms;
  settings.streams.latest_wins = options.delivery == "latest-wins";
  check_outputs(settings);
  load::run_load(settings);
}

/// A time as its number of milliseconds.
CLI::Validator time_in_ms() {
  const auto transform = [](std::string& word) -> std::string {
    static const std::map<std::string, double> units{{"us", 1e-3}, {"ms", 1}, {"s", 1e3}};
    double number = 0;
    const char* const end = word.data() + word.size();
    const auto [rest, error] = std::from_chars(word.data(), end, number);
    const auto unit = units.find(std::string(std::find_if(rest, end, [](char c) { return c != ' '; }), end));
    if (error != std::errc() || unit == units.end())
      return "'" + word + "' is not a time with its unit, such as 5ms, 800us or 0.1s";
    if (!(number > 0 && std::isfinite(number))) return "'" + word + "' is not a time greater than 0";
    word = CLI::detail::to_string(number * unit->second);
    return "";
  };
  return CLI::Validator(transform, "");
}

CLI::Range count() { return CLI::Range(uint64_t{1}, kMaxStreams); }

CLI::Option* add_number(CLI::App& command, const char* name, double& value, const char* help, double min, double max) {
  return command.add_option(name, value, help)->check(finite())->check(CLI::Range(min, max))->capture_default_str();
}

void add_input_options(CLI::App& command, load::InputSettings& input) {
  command.add_option("--scene", input.scene, "Procedural scene, see 'collidectl scenes', played back and forth")
      ->type_name("SCENE")
      ->check(known_scene());
  add_scale_option(command, input.scale);
  command.add_option("--steps", input.steps, "Frames of the scene from its beginning to its end")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command
      .add_option("--frames", input.files,
                  "Recorded frames, files or folders of them, in natural order, such as frames/*.ply")
      ->type_name("FILE")
      ->excludes("--scene")
      ->excludes("--scale")
      ->excludes("--steps");
}

void add_stream_options(CLI::App& command, LoadOptions& options) {
  load::StreamSettings& streams = options.settings.streams;
  command.add_option("--clients", streams.clients, "Clients")->check(count())->capture_default_str();
  command.add_option("--scenes", streams.scenes, "Scenes of each client, a stream each")
      ->check(count())
      ->capture_default_str();
  command.add_option("--window", streams.window, "Frames in flight on a stream")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command.add_option("--delivery", options.delivery, "What becomes of frames that arrive too fast")
      ->check(CLI::IsMember({"lossless", "latest-wins"}))
      ->capture_default_str();
  command.add_flag("--shared-connections", streams.shares_connections,
                   "A connection for each client, not for each stream");
  command.add_option("--warm-up", streams.warm_up, "First frames of each stream, which are not counted")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command.add_option("--generations", streams.generations, "Runs, each on new scenes, once those before are deleted")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--workers", streams.workers, "Pairs of threads that send and receive; 0: by the number of cores")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
}

void add_pace_options(CLI::App& command, LoadOptions& options) {
  load::PaceSettings& pace = options.settings.pace;
  add_number(command, "--rate", options.rate, "Open loop: frames a second of each stream", 0.001, 1e6)->default_str("");
  command.add_option("--ramp", options.ramp, "Open loop at a changing rate: FROM:TO:SECONDS, or several with commas")
      ->type_name("RAMP");
  command.add_flag("--closed-loop", options.is_closed, "Each stream keeps its window full");
  add_number(command, "--seconds", options.seconds, "Duration", 0.01, 1e6)->excludes("--ramp");
  command.add_option("--arrivals", options.arrivals, "Frames of a stream come evenly, or at random (poisson)")
      ->check(CLI::IsMember({"fixed", "poisson"}))
      ->excludes("--closed-loop")
      ->capture_default_str();
  command.add_option("--seed", pace.seed, "Of --arrivals poisson")->check(whole_number())->capture_default_str();
  add_number(command, "--drain-seconds", pace.drain_seconds, "Wait at the end for frames that are overdue", 0, 3600);
}

void add_search_options(CLI::App& command, LoadOptions& options) {
  load::FindMaxSettings& search = options.settings.find_max;
  command.add_flag("--find-max", options.is_search, "Find the highest rate of all streams that holds --p99")
      ->excludes("--seconds");
  command.add_option("--p99", options.p99_ms, "Bound of the latency's 99th percentile, such as 5ms, 800us, 0.1s")
      ->type_name("TIME")
      ->transform(time_in_ms());
  add_number(command, "--from", search.from, "Rate to begin with; 0: 10 frames a second of each stream", 0, 1e6);
  add_number(command, "--trial-seconds", search.trial_seconds, "Duration of one trial", 0.1, 1e5);
  add_number(command, "--precision", search.precision, "How far the result may be from a rate that failed", 0.001, 1);
}

void add_output_options(CLI::App& command, LoadSettings& settings) {
  command
      .add_option("--metrics-url", settings.metrics_url,
                  "Metrics of a running daemon, such as http://127.0.0.1:9464/metrics, to compare counts with")
      ->type_name("URL")
      ->needs("--server");
  command.add_option("--out", settings.out, "JSON file; -: standard output")->type_name("FILE");
  command.add_option("--html", settings.html, "One HTML page with plots")->type_name("FILE");
  command.add_flag("--json", settings.json, "Print one JSON object instead of the report");
}

constexpr auto kFooter =
    "Latency runs from when a frame should have been sent to its complete answer, so that a daemon that stands\n"
    "still is seen in every frame that it delays; service time runs from when it was sent. A closed loop sends\n"
    "only what answers make room for, and cannot show queues beyond its window. Streams run over gRPC.\n"
    "\n"
    "  collidectl load --scene reef_knot --clients 10 --scenes 4 --rate 30 --seconds 60 --html load.html\n"
    "  collidectl load --scene funnel --scale 0.2 --clients 20 --ramp 10:100:30 --arrivals poisson\n"
    "  collidectl load --frames frames/*.ply --clients 4 --closed-loop --window 4\n"
    "  collidectl load --scene reef_knot --clients 8 --find-max --p99 5ms\n"
    "  collidectl load --scene funnel --rate 60 --server gpu:50551 --metrics-url http://gpu:9464/metrics\n"
    "\n"
    "Exit codes: 0 done, 1 failure, streams that ended early among them, 2 bad usage, 128 + n interrupted by signal n.";

}  // namespace

void add_load(CLI::App& app) {
  auto options = std::make_shared<LoadOptions>();
  CLI::App& command = *app.add_subcommand("load", "Load a daemon with many streams and measure each frame's latency");
  command.footer(kFooter);
  add_input_options(command, options->settings.input);
  add_stream_options(command, *options);
  add_pace_options(command, *options);
  add_search_options(command, *options);
  add_detection_options(command, options->settings.detection);
  add_position_format_option(command, options->settings.input.position_format);
  add_server_options(command, options->settings.server);
  add_output_options(command, options->settings);
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
