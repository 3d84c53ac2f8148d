// Runs scenes through the engine and writes what each stage cost, as JSON, to standard output.

#include <chrono>
#include <cstring>
#include <iostream>
#include <map>
#include <span>
#include <stdexcept>

#include "tests/bench/inputs.hpp"
#include "tests/bench/levels.hpp"
#include "tests/bench/report.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr const char* kUsage =
    "usage: collided_bench [--backend cpu|cuda] [--mode ccd|dcd] [--accuracy LEVEL] [--scalar f32|f64]\n"
    "                      [--thickness H] [--steps N] [--warm-up N] [--threads N] [--scene NAME] [--scale S]\n"
    "                      [--date TEXT] [--commit TEXT] [--check-same] [--compare-levels]\n"
    "LEVEL is candidates, fast, guarded, certified (default) or exact. Real frames come from the data folder\n"
    "(COLLIDED_DATA). --check-same prints `scene digest contacts` lines instead: equal lines mean equal result\n"
    "arrays, byte for byte, in CCD and DCD, F32 and F64. --compare-levels runs all levels and reports side by side\n"
    "(CCD): per scene and level, narrow phase and all stages, as times and as ratios to FAST.\n";

constexpr std::pair<const char*, Backend> kBackends[] = {{"cpu", Backend::kCpu}, {"cuda", Backend::kCuda}};
constexpr std::pair<const char*, Mode> kModes[] = {{"ccd", Mode::kCcd}, {"dcd", Mode::kDcd}};
constexpr std::pair<const char*, Scalar> kScalars[] = {{"f32", Scalar::kF32}, {"f64", Scalar::kF64}};
constexpr std::pair<const char*, Accuracy> kLevels[] = {{"candidates", Accuracy::kCandidates},
                                                        {"fast", Accuracy::kFast},
                                                        {"guarded", Accuracy::kGuarded},
                                                        {"certified", Accuracy::kCertified},
                                                        {"exact", Accuracy::kExact}};

struct Options {
  SceneSpec spec;
  std::string date, commit, scene;
  double scale = 1;
  int steps = 20, warm_up = 2;
  bool check_same = false, compare_levels = false;
};

template <class T>
T choice(const std::string& option, const std::string& value, std::span<const std::pair<const char*, T>> known) {
  for (const auto& [name, result] : known)
    if (value == name) return result;
  throw std::invalid_argument(option + " cannot be '" + value + "'");
}

void set_option(Options& o, const std::string& option, const std::string& value) {
  if (option == "--backend")
    o.spec.backend = choice<Backend>(option, value, kBackends);
  else if (option == "--mode")
    o.spec.mode = choice<Mode>(option, value, kModes);
  else if (option == "--accuracy")
    o.spec.accuracy = choice<Accuracy>(option, value, kLevels);
  else if (option == "--scalar")
    o.spec.scalar = choice<Scalar>(option, value, kScalars);
  else if (option == "--thickness")
    o.spec.thickness = std::stod(value);
  else if (option == "--threads")
    o.spec.threads = std::stoi(value);
  else if (option == "--steps")
    o.steps = std::stoi(value);
  else if (option == "--warm-up")
    o.warm_up = std::stoi(value);
  else if (option == "--scene")
    o.scene = value;
  else if (option == "--scale")
    o.scale = std::stod(value);
  else if (option == "--date")
    o.date = value;
  else if (option == "--commit")
    o.commit = value;
  else
    throw std::invalid_argument("unknown option " + option);
}

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const bool check = !std::strcmp(argv[i], "--check-same"), compare = !std::strcmp(argv[i], "--compare-levels");
    o.check_same |= check;
    o.compare_levels |= compare;
    if (check || compare) continue;
    if (i + 1 == argc) throw std::invalid_argument(std::string(argv[i]) + " needs a value");
    set_option(o, argv[i], argv[i + 1]);
    ++i;
  }
  if (o.steps < 1) throw std::invalid_argument("--steps must be at least 1");
  return o;
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
  const Case first = input.at(0, o.steps);
  const auto detector = Detector::create(spec_for(first, o.spec));
  SceneReport report;
  report.name = input.name;
  report.triangles = detector->topology().triangles.size();
  report.steps = o.steps;
  for (int i = 0; i < o.warm_up; ++i)  // buffers grow to the size of the hardest step
    detector->detect(
        Frame(i == 0 ? first : input.at(o.steps - 1, o.steps), o.spec.mode, o.spec.scalar, i == 0).input());
  Stages stages;
  std::vector<double> wall;
  for (int step = 0; step < o.steps; ++step) {
    const Frame frame(input.at(step, o.steps), o.spec.mode, o.spec.scalar, o.warm_up == 0 && step == 0);
    const auto begin = std::chrono::steady_clock::now();
    const FrameResult result = detector->detect(frame.input());
    wall.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    stages.add(result.stages);
    report.counts = result.counts;
    report.replays += result.replays;
    report.digest = report.digest * 31 + digest(result);
  }
  report.stage_ms = stages.medians();
  report.total_ms = stages.total();
  report.wall_ms = median(wall);
  report.device_bytes = bytes_of(*detector);
  return report;
}

std::string device_name(Backend backend) {
  for (const DeviceInfo& device : list_devices())
    if (device.backend == backend) return device.name;
  throw std::runtime_error("no such device");
}

RunReport run_all(const Options& o) {
  RunReport report{.date = o.date,
                   .commit = o.commit,
                   .device = device_name(o.spec.backend),
                   .mode = o.spec.mode == Mode::kCcd ? "ccd" : "dcd",
                   .accuracy = kLevels[static_cast<size_t>(o.spec.accuracy)].first,
                   .scalar = o.spec.scalar == Scalar::kF32 ? "f32" : "f64",
                   .thickness = o.spec.thickness,
                   .scenes = {}};
  for (const BenchInput& input : bench_inputs(o.scene, o.scale)) {
    std::cerr << input.name << "\n";
    report.scenes.push_back(run_scene(input, o));
  }
  if (report.scenes.empty()) throw std::invalid_argument("no scene is called " + o.scene);
  return report;
}

void compare_levels(const Options& o) {
  std::vector<LevelReport> reports;
  for (const BenchInput& input : bench_inputs(o.scene, o.scale)) {
    std::cerr << input.name << "\n";
    reports.push_back(compare_levels(input, o.spec, o.steps, 3));
  }
  std::cout << "{\n  \"date\": \"" << o.date << "\", \"commit\": \"" << o.commit << "\", \"device\": \""
            << device_name(o.spec.backend) << "\",\n  \"scalar\": \"" << (o.spec.scalar == Scalar::kF32 ? "f32" : "f64")
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
        spec.weights = true;
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
  try {
    const Options options = parse(argc, argv);
    if (options.check_same)
      check_same(options);
    else if (options.compare_levels)
      compare_levels(options);
    else
      write_json(std::cout, run_all(options));
    return 0;
  } catch (const std::invalid_argument& e) {
    std::cerr << e.what() << "\n" << kUsage;
    return 2;
  } catch (const std::exception& e) {
    std::cerr << "collided_bench: " << e.what() << "\n";
    return 1;
  }
}
