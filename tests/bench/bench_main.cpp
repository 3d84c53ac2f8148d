// Runs scenes through the engine and writes the cost of each stage, as JSON, to standard output.

#include <CLI/CLI.hpp>
#include <chrono>
#include <iostream>
#include <iterator>
#include <map>
#include <stdexcept>

#include "tests/bench/engines.hpp"
#include "tests/bench/inputs.hpp"
#include "tests/bench/levels.hpp"
#include "tests/bench/report.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

template <class T>
using Names = std::vector<std::pair<std::string, T>>;
const Names<Backend> kBackends{{"cpu", Backend::kCpu}, {"cuda", Backend::kCuda}};
const Names<Mode> kModes{{"ccd", Mode::kCcd}, {"dcd", Mode::kDcd}};
const Names<Scalar> kScalars{{"f32", Scalar::kF32}, {"f64", Scalar::kF64}};
const Names<Accuracy> kLevels{{"candidates", Accuracy::kCandidates},
                              {"fast", Accuracy::kFast},
                              {"guarded", Accuracy::kGuarded},
                              {"certified", Accuracy::kCertified},
                              {"exact", Accuracy::kExact}};
const Names<Engine> kEngines{{"auto", Engine::kAuto},
                             {"octree", Engine::kOctree},
                             {"top-down", Engine::kTopDown},
                             {"bottom-up", Engine::kBottomUp},
                             {"uniform-grid", Engine::kUniformGrid},
                             {"two-level-grid", Engine::kTwoLevelGrid},
                             {"lbvh", Engine::kLbvh},
                             {"vss", Engine::kVss},
                             {"all-pairs", Engine::kAllPairs}};

struct Options {
  SceneSpec spec;
  std::string date, commit, scene;
  double scale = 1;
  int steps = 20, warm_up = 2;
  bool in_slot = false, normals = false;
  bool check_same = false, compare_levels = false, compare_engines = false;
};

template <class T>
const std::string& name_of(const Names<T>& names, T value) {
  for (const auto& [name, known] : names)
    if (known == value) return name;
  throw std::logic_error("a value without a name");
}

template <class T>
void add_choice(CLI::App& app, const std::string& option, T& value, const Names<T>& names, const char* what) {
  app.add_option(option, value, what)
      ->transform(CLI::CheckedTransformer(names).description(""))
      ->type_name("")
      ->default_str(name_of(names, value));
}

void add_options(CLI::App& app, Options& o) {
  app.footer("Real frames come from the data folder (COLLIDED_DATA).");
  add_choice(app, "--backend", o.spec.device.backend, kBackends, "cpu or cuda");
  add_choice(app, "--mode", o.spec.mode, kModes, "ccd or dcd");
  add_choice(app, "--accuracy", o.spec.accuracy, kLevels, "candidates, fast, guarded, certified or exact");
  add_choice(app, "--scalar", o.spec.scalar, kScalars, "f32 or f64");
  add_choice(app, "--engine", o.spec.engine, kEngines,
             "auto, octree, top-down, bottom-up, uniform-grid, two-level-grid, lbvh, vss or all-pairs");
  app.add_flag("--normals", o.normals, "Contacts have normals too");
  app.add_option("--thickness", o.spec.thickness, "Contact distance")->capture_default_str();
  app.add_option("--threads", o.spec.threads, "CPU threads; 0: all cores")->capture_default_str();
  app.add_option("--steps", o.steps, "Steps that count")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_flag("--in-slot", o.in_slot,
               "Positions lie in a slot's memory before a step, where the daemon decodes them to");
  app.add_option("--warm-up", o.warm_up, "Steps before")->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--scene", o.scene, "One scene; default: all");
  app.add_option("--scale", o.scale, "Refines the grids")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--date", o.date, "Recorded in the result");
  app.add_option("--commit", o.commit, "Recorded in the result");
  app.add_flag("--check-same", o.check_same,
               "Print `scene digest contacts` lines instead: equal lines mean equal result arrays, byte for byte, in "
               "CCD and DCD, F32 and F64");
  app.add_flag("--compare-levels", o.compare_levels,
               "Run all levels side by side (CCD): per scene and level, narrow phase and all stages, as times and as "
               "ratios to FAST");
  app.add_flag(
      "--compare-engines", o.compare_engines,
      "Run all engines, or that of --engine: per scene and engine, tests, registrations and pairs of each step (no "
      "times)");
}

uint64_t bytes_of(const Detector& detector) {
  uint64_t sum = 0;
  for (const MemoryPart& part : detector.memory()) sum += part.bytes;
  return sum;
}

// Stage times of all steps, by stage; a stage that runs several times in a step counts with its sum.
class Stages {
 public:
  void add(const std::vector<StageTime>& stages) {
    std::map<std::string, double> sums;
    double total = 0;
    for (const StageTime& s : stages) {
      if (!sums.contains(s.stage) && !samples_.contains(s.stage)) order_.push_back(s.stage);
      sums[s.stage] += s.milliseconds;
      total += s.milliseconds;
    }
    for (const auto& [stage, ms] : sums) samples_[stage].push_back(ms);
    totals_.push_back(total);
  }
  double total() const { return median(totals_); }
  std::vector<std::pair<std::string, double>> medians() const {
    std::vector<std::pair<std::string, double>> out;
    for (const std::string& stage : order_) out.emplace_back(stage, median(samples_.at(stage)));
    return out;
  }

 private:
  std::vector<std::string> order_;
  std::map<std::string, std::vector<double>> samples_;
  std::vector<double> totals_;
};

SceneReport run_scene(const BenchInput& input, const Options& o) {
  const auto detector = Detector::create(spec_for(input.at(0, o.steps), o.spec));
  SceneReport report;
  report.name = input.name;
  report.triangles = detector->topology().triangles.size();
  report.steps = o.steps;
  Stages stages;
  std::vector<double> wall;
  play_steps(*detector, input, o.spec, {o.steps, o.warm_up, o.in_slot}, [&](const auto& play) {
    const auto begin = std::chrono::steady_clock::now();
    const FrameResult result = play();
    wall.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    stages.add(result.stages);
    report.counts = result.counts;
    report.replays += result.replays;
    report.digest = report.digest * 31 + digest(result);
  });
  report.stage_ms = stages.medians();
  report.total_ms = stages.total();
  report.wall_ms = median(wall);
  report.device_bytes = bytes_of(*detector);
  return report;
}

RunReport run_all(const Options& o) {
  RunReport report{.date = o.date,
                   .commit = o.commit,
                   .device = device_name(o.spec.device.backend),
                   .mode = name_of(kModes, o.spec.mode),
                   .accuracy = name_of(kLevels, o.spec.accuracy),
                   .scalar = name_of(kScalars, o.spec.scalar),
                   .thickness = o.spec.thickness,
                   .positions = o.in_slot ? "in a slot" : "in pageable memory",
                   .scenes = {}};
  for (const BenchInput& input : bench_inputs(o.scene, o.scale)) {
    std::cerr << input.name << "\n";
    report.scenes.push_back(run_scene(input, o));
  }
  if (report.scenes.empty()) throw std::invalid_argument("no scene is called " + o.scene);
  return report;
}

void compare_engines(const Options& o) {
  Names<Engine> engines(std::next(kEngines.begin()), kEngines.end());  // all but auto
  if (o.spec.engine != Engine::kAuto) engines = {{name_of(kEngines, o.spec.engine), o.spec.engine}};
  std::vector<EngineRun> runs;
  for (const BenchInput& input : bench_inputs(o.scene, o.scale)) {
    std::cerr << input.name << "\n";
    for (EngineRun& run : compare_engines(input, o.spec, engines, o.steps, o.warm_up)) runs.push_back(std::move(run));
  }
  std::cout << "{\n  \"date\": \"" << o.date << "\", \"commit\": \"" << o.commit << "\", \"device\": \""
            << device_name(o.spec.device.backend) << "\",\n  \"mode\": \"" << name_of(kModes, o.spec.mode)
            << "\", \"scalar\": \"" << name_of(kScalars, o.spec.scalar) << "\", \"steps\": " << o.steps
            << ",\n  \"runs\": ";
  write_engines(std::cout, runs);
  std::cout << "\n}\n";
}

void compare_levels(const Options& o) {
  std::vector<LevelReport> reports;
  for (const BenchInput& input : bench_inputs(o.scene, o.scale)) {
    std::cerr << input.name << "\n";
    reports.push_back(compare_levels(input, o.spec, o.steps, 3));
  }
  std::cout << "{\n  \"date\": \"" << o.date << "\", \"commit\": \"" << o.commit << "\", \"device\": \""
            << device_name(o.spec.device.backend) << "\",\n  \"scalar\": \"" << name_of(kScalars, o.spec.scalar)
            << "\", \"steps\": " << o.steps << ",\n  \"scenes\": ";
  write_levels(std::cout, reports);
  std::cout << "\n}\n";
}

// One scene at one time is enough here: steps add cost, not coverage.
void check_same(const Options& o) {
  for (const BenchInput& input : bench_inputs(o.scene, o.scale)) {
    const Case c = input.at(3, 5);
    for (Mode mode : {Mode::kCcd, Mode::kDcd}) {
      for (Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
        SceneSpec spec = o.spec;
        spec.mode = mode;
        spec.scalar = scalar;
        spec.thickness = mode == Mode::kDcd ? dcd_thickness(input.name) : 0;
        spec.fields = spec.fields.with(ContactField::kWeights);
        const FrameResult r = run_case(c, spec);
        std::cout << input.name << (mode == Mode::kCcd ? " ccd" : " dcd")
                  << (scalar == Scalar::kF32 ? " f32 " : " f64 ") << std::hex << digest(r) << std::dec << " "
                  << r.vertex_triangle.size() << " " << r.edge_edge.size() << std::endl;
      }
    }
  }
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided::test;
  CLI::App app("Runs scenes through the engine and writes what each stage cost, as JSON, to standard output");
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  if (options.normals) options.spec.fields = options.spec.fields.with(collided::ContactField::kNormals);
  try {
    if (options.check_same)
      check_same(options);
    else if (options.compare_engines)
      compare_engines(options);
    else if (options.compare_levels)
      compare_levels(options);
    else
      write_json(std::cout, run_all(options));
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "collided_bench: " << e.what() << "\n";
    return 1;
  }
}
