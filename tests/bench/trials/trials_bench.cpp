// What it costs that a scene tries engines and lists: steps of --engine auto beside the same steps of each engine alone.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/bench/inputs.hpp"
#include "tests/bench/report.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

using nlohmann::json;

struct Options {
  Backend backend = Backend::kCpu;
  std::string scene;
  int frames = 1000, threads = 0, warm_up = 0, period = 0;
  double scale = 1;
};

/// Moves everything towards a corner of the scene, the more the nearer it is: triangles of one size become triangles of
/// many sizes, which other engines are best at.
Positions crowded(Positions positions) {
  constexpr double kPower = 3, kHalf = 4;
  for (Vec3d& p : positions)
    for (double& x : p) x = kHalf * std::copysign(std::pow(std::abs(x) / kHalf, kPower), x);
  return positions;
}

Case crowded(Case c) {
  std::ranges::transform(c.start, c.start.begin(), [](const Positions& p) { return crowded(p); });
  std::ranges::transform(c.end, c.end.begin(), [](const Positions& p) { return crowded(p); });
  return c;
}

/// A detector of one engine, and what its steps took.
struct Side {
  std::string name;
  std::unique_ptr<Detector> detector;
  std::vector<double> ms = {};  ///< GPU or CPU time of each step
  uint64_t engine_trials = 0, list_trials = 0, list_steps = 0, switches = 0;
  uint64_t repeated = 0;  ///< steps that ran again, as lists were too short or the tree did not fit
  double engine_trial_ms = 0, list_trial_ms = 0;
  Engine engine = Engine::kAuto;
  json comparisons = json::array();  ///< what each trial of an engine told
  bool was_trial = false;
  FrameResult last = {};

  void run(const FrameInput& input, bool counts) {
    last = {};
    last = detector->detect(input);
    if (!counts) return;
    const double step = last.step_milliseconds;
    ms.push_back(step);
    const bool tries_engine = last.broad_phase.reason == EngineReason::kTrial,
               tries_lists = last.reuse.reason == ReuseReason::kTrial;
    engine_trials += tries_engine, list_trials += tries_lists;
    if (std::exchange(was_trial, tries_engine) && !tries_engine)
      comparisons.push_back({{"frame", ms.size()},
                             {"octree_ms", last.broad_phase.octree_milliseconds},
                             {"lbvh_ms", last.broad_phase.lbvh_milliseconds}});
    list_steps += last.reuse.use != ListUse::kNone;
    repeated += last.replays > 0;
    (tries_engine ? engine_trial_ms : list_trial_ms) += tries_engine || tries_lists ? step : 0;
    if (!tries_engine) switches += std::exchange(engine, last.broad_phase.engine) != last.broad_phase.engine;
  }
  double sum(size_t from, size_t to) const { return std::accumulate(ms.begin() + from, ms.begin() + to, 0.0); }
  double percentile(double share) const {
    std::vector<double> sorted = ms;
    std::ranges::sort(sorted);
    return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
  }
};

Side side(const Case& c, const Options& o, const std::string& name, Engine engine) {
  SceneSpec spec;
  spec.device.backend = o.backend;
  spec.threads = o.threads;
  spec.engine = engine;
  return {.name = name, .detector = Detector::create(spec_for(c, spec))};
}

/// All sides in turn, each first in turn. With a period the scene changes, and changes back, after so many frames; each
/// stretch is compared with the engine that was fastest in it.
json measure(const BenchInput& input, const Options& o) {
  const Case first = input.at(0, o.frames);
  std::vector<Side> sides;
  sides.push_back(side(first, o, "auto", Engine::kAuto));
  sides.push_back(side(first, o, "octree", Engine::kOctree));
  sides.push_back(side(first, o, "lbvh", Engine::kLbvh));
  for (int i = 0; i < o.warm_up + o.frames; ++i) {
    const int step = std::max(0, i - o.warm_up);
    Case c = input.at(step, o.frames);
    if (o.period > 0 && step / o.period % 2 == 1) c = crowded(std::move(c));
    const Frame frame(c, Mode::kCcd, Scalar::kF32, i == 0);
    for (size_t k = 0; k < sides.size(); ++k)
      sides[(k + static_cast<size_t>(i)) % sides.size()].run(frame.input(), i >= o.warm_up);
    for (const Side& other : sides)
      if (!same_contacts(sides.front().last, other.last))
        throw std::runtime_error(input.name + ": step " + std::to_string(step) + ": " + other.name +
                                 " has other contacts than auto");
  }
  const auto frames = static_cast<size_t>(o.frames), stretch = o.period > 0 ? static_cast<size_t>(o.period) : frames;
  double best = 0;
  for (size_t from = 0; from < frames; from += stretch) {
    const size_t to = std::min(frames, from + stretch);
    best += std::min(sides[1].sum(from, to), sides[2].sum(from, to));
  }
  const Side &own = sides[0], &fixed = sides[1].sum(0, frames) < sides[2].sum(0, frames) ? sides[1] : sides[2];
  json out = {{"scene", input.name},
              {"triangles", own.detector->topology().triangles.size()},
              {"frames", o.frames},
              {"period", o.period},
              {"best_engine", fixed.name},
              {"time_ratio", own.sum(0, frames) / best},
              {"p95_ratio", own.percentile(0.95) / fixed.percentile(0.95)},
              {"engine_trials", own.engine_trials},
              {"engine_trial_ms", own.engine_trial_ms},
              {"list_trials", own.list_trials},
              {"list_trial_ms", own.list_trial_ms},
              {"list_steps", own.list_steps},
              {"switches", own.switches},
              {"comparisons", own.comparisons},
              {"sides", json::object()}};
  for (const Side& s : sides)
    out["sides"][s.name] = {{"mean_ms", s.sum(0, frames) / static_cast<double>(frames)},
                            {"p50_ms", s.percentile(0.5)},
                            {"p95_ms", s.percentile(0.95)},
                            {"p99_ms", s.percentile(0.99)},
                            {"max_ms", s.percentile(1)},
                            {"repeated_steps", s.repeated}};
  return out;
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided::test;
  CLI::App app(
      "Times steps of --engine auto beside the same steps of the octree and of the hierarchy alone, as JSON, to standard "
      "output: what it costs to try engines and lists of neighbours");
  Options options;
  std::string backend = "cpu", date, commit;
  app.add_option("--backend", backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--scene", options.scene, "One scene; default: all");
  app.add_option("--scale", options.scale, "Triangles grow with its square")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--frames", options.frames, "Of each scene")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--warm-up", options.warm_up, "Frames before, which do not count")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--period", options.period, "The scene crowds into a corner, and comes back, after so many frames; 0: never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--threads", options.threads, "Of the host; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--date", date, "Recorded in the result");
  app.add_option("--commit", commit, "Recorded in the result");
  CLI11_PARSE(app, argc, argv);
  try {
    options.backend = backend == "cuda" ? collided::Backend::kCuda : collided::Backend::kCpu;
    json runs = json::array();
    for (const BenchInput& input : bench_inputs(options.scene, options.scale)) {
      runs.push_back(measure(input, options));
      std::cerr << runs.back() << "\n";
    }
    if (runs.empty()) throw std::invalid_argument("no scene is called " + options.scene);
    std::cout << json{{"date", date},
                      {"commit", commit},
                      {"device", device_name(options.backend, options.threads)},
                      {"runs", runs}}
                     .dump(1)
              << "\n";
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "collided_trials_bench: " << e.what() << "\n";
    return 1;
  }
}
