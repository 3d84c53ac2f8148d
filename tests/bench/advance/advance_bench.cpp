// Simulates with advances, and writes how far each step went as JSON; every step ends with a search for triangles that
// cross, decided exactly.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/support/sim/simulations.hpp"

namespace collided::test {
namespace {

/// Pairs of triangles that share a point, of meshes that may touch.
class Crossings {
 public:
  Crossings(const Bodies& bodies, Backend backend, Scalar scalar) : scalar_(scalar) {
    SceneSpec spec;
    spec.device.backend = backend;
    spec.scalar = scalar;
    spec.mode = Mode::kDcd;
    spec.accuracy = Accuracy::kExact;
    spec.kinds = {.triangle_triangle = true};
    scene_ = Detector::create(spec_for(bodies.meshes, spec));
  }
  size_t count(const Case& way) {
    const FrameResult found = scene_->detect(Frame(way, Mode::kDcd, scalar_, is_first_).input());
    is_first_ = false;
    return found.triangle_triangle.size();
  }

 private:
  Scalar scalar_;
  std::unique_ptr<Detector> scene_;
  bool is_first_ = true;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Mode {
  const char* name;
  AdvanceMode mode;
};
constexpr Mode kModes[] = {{"all_or_one", AdvanceMode::kAllOrOne},
                           {"per_mesh", AdvanceMode::kPerMesh},
                           {"per_vertex", AdvanceMode::kPerVertex}};

nlohmann::json run(const Simulation& s, Backend backend, Scalar scalar, const Mode& mode, int frames) {
  Simulator simulator(s.make(), backend, scalar, mode.mode);
  Crossings crossings(simulator.bodies(), backend, scalar);
  std::vector<double> advanced, ways, of_largest;
  size_t crossed = 0, frozen = 0, longest_freeze = 0, freeze = 0, shortened = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < frames; ++i) {
    const Simulator::Step step = simulator.step();
    advanced.push_back(step.advanced);
    ways.push_back(step.way);
    if (step.earliest_toi < 1) ++shortened;
    if (step.earliest_toi < 1 && step.earliest_toi > 0) of_largest.push_back(step.advanced / step.earliest_toi);
    freeze = step.way < 1e-6 ? freeze + 1 : 0;
    frozen += freeze > 0 ? 1 : 0;
    longest_freeze = std::max(longest_freeze, freeze);
    crossed += crossings.count(simulator.last_way());
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double mean_way = std::accumulate(ways.begin(), ways.end(), 0.0) / frames;
  std::cerr << s.name << ' ' << mode.name << ' ' << frames << " steps, " << crossed << " pairs of triangles met, "
            << shortened << " shortened, " << frozen << " frozen (" << longest_freeze
            << " in a row), advanced / largest " << median(of_largest) << ", mean way " << mean_way << ", least "
            << *std::min_element(ways.begin(), ways.end()) << ", " << seconds << " s\n";
  uint64_t triangles = 0;
  for (const MeshSpec& m : simulator.bodies().meshes.meshes) triangles += m.triangles.size();
  return {{"simulation", s.name},
          {"mode", mode.name},
          {"scalar", scalar == Scalar::kF64 ? "f64" : "f32"},
          {"triangles", triangles},
          {"steps", frames},
          {"crossings", crossed},
          {"shortened", shortened},
          {"frozen", frozen},
          {"longest_freeze", longest_freeze},
          {"of_largest_median", median(of_largest)},
          {"mean_way", mean_way},
          {"least_way", *std::min_element(ways.begin(), ways.end())},
          {"advanced", advanced}};
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided;
  CLI::App app("Simulates with advances and writes how far each step went, as JSON, to standard output");
  std::string backend = "cpu", only, only_mode = "all_or_one", only_scalar, date, commit;
  bool no_steps = false;
  int frames = 1000;
  app.add_option("--backend", backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--simulation", only, "One of them; default: all");
  app.add_option("--mode", only_mode, "all_or_one, per_mesh, per_vertex or all")
      ->check(CLI::IsMember({"all_or_one", "per_mesh", "per_vertex", "all"}))
      ->capture_default_str();
  app.add_flag("--no-steps", no_steps, "Leave out how far each single step went");
  app.add_option("--scalar", only_scalar, "f32 or f64; default: both")->check(CLI::IsMember({"f32", "f64"}));
  app.add_option("--frames", frames, "Steps of each")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--date", date, "Recorded in the result");
  app.add_option("--commit", commit, "Recorded in the result");
  CLI11_PARSE(app, argc, argv);
  const Backend on = backend == "cuda" ? Backend::kCuda : Backend::kCpu;
  nlohmann::json out{{"format", "collided advance 1"},
                     {"date", date},
                     {"commit", commit},
                     {"backend", backend},
                     {"runs", nlohmann::json::array()}};
  for (const test::Simulation& s : test::simulations())
    for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
      for (const test::Mode& mode : test::kModes) {
        if (!only.empty() && only != s.name) continue;
        if (only_mode != "all" && only_mode != mode.name) continue;
        if (!only_scalar.empty() && only_scalar != (scalar == Scalar::kF64 ? "f64" : "f32")) continue;
        out["runs"].push_back(test::run(s, on, scalar, mode, frames));
        if (no_steps) out["runs"].back().erase("advanced");
      }
  std::cout << out.dump(1) << '\n';
}
