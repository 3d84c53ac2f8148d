// Whole frames at EXACT beside the same at CERTIFIED, on real frames and where thousands of features touch exactly.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/bench/exact/costly_kinds.hpp"
#include "tests/bench/inputs.hpp"
#include "tests/bench/report.hpp"

namespace collided::test {
namespace {

using nlohmann::json;

struct Options {
  Backend backend = Backend::kCpu;
  std::string scene;
  int frames = 40, threads = 0;
  double scale = 1;
  bool costly = false;
};

/// How a cloth and the floor below it touch where they begin: in the plane z = 0, the cloth's corners in the faces of
/// the floor, or on its corners.
struct Rest {
  const char* name;
  double shift_x, shift_y;  ///< of the cloth against the floor, in cells
  double along;             ///< how far it slides, in cells
};
constexpr Rest kRests[] = {{"resting", 0.5, 0.25, 0}, {"sliding", 0.5, 0.25, 0.25}, {"coincident", 0, 0, 0.125}};

std::vector<std::array<uint32_t, 3>> grid_triangles(uint32_t cells) {
  std::vector<std::array<uint32_t, 3>> triangles;
  const uint32_t row = cells + 1;
  for (uint32_t j = 0; j < cells; ++j)
    for (uint32_t i = 0; i < cells; ++i) {
      const uint32_t a = j * row + i;
      triangles.push_back({a, a + 1, a + row});
      triangles.push_back({a + 1, a + row + 1, a + row});
    }
  return triangles;
}

template <class Point>
Positions grid(uint32_t cells, const Point& point) {
  Positions positions;
  for (uint32_t j = 0; j <= cells; ++j)
    for (uint32_t i = 0; i <= cells; ++i) positions.push_back(point(i, j));
  return positions;
}

/// 145,924 triangles at scale 1. The cloth lies on the floor in a patch of 18 by 18 cells and is half a cell above it
/// elsewhere; by the end of the step it has sunk by a 64th of a cell.
Case resting(const Rest& rest, double scale) {
  const constexpr uint32_t kPatch = 18;
  const uint32_t cells = std::max(kPatch, static_cast<uint32_t>(191 * scale));
  const auto cloth = [&](double slide, double sink) {
    return grid(cells, [&](uint32_t i, uint32_t j) {
      const bool rests = i <= kPatch && j <= kPatch;
      return Vec3d{i + rest.shift_x + slide, j + rest.shift_y, (rests ? 0.0 : 0.5) - sink};
    });
  };
  Case c{rest.name, {}, {}, {}};
  add_mesh(c, grid_triangles(cells),
           grid(cells,
                [](uint32_t i, uint32_t j) {
                  return Vec3d{double(i), double(j), 0};
                }),
           {}, true);
  add_mesh(c, grid_triangles(cells), cloth(0, 0), cloth(rest.along, 1.0 / 64));
  return c;
}

std::vector<CostlyKind> costly_cases(const Options& o) {
  std::vector<CostlyKind> all;
  for (CostlyKind& kind : costly_kinds())
    if (o.scene.empty() || o.scene == kind.input.name) all.push_back(std::move(kind));
  if (all.empty()) throw std::invalid_argument("no costly kind is called " + o.scene);
  return all;
}

std::vector<CostlyKind> cases(const Options& o) {
  if (o.costly) return costly_cases(o);
  std::vector<CostlyKind> all;
  for (const char* name : {"cloth_funnel_227_228", "cloth_ball_92_93", "touching_boxes"})
    if (o.scene.empty() || o.scene == name)
      for (const BenchInput& input : bench_inputs(name, o.scale)) {
        all.push_back({input.at(3, 5)});
        all.back().input.name = name;
      }
  for (const Rest& rest : kRests)
    if (o.scene.empty() || o.scene == rest.name) all.push_back({resting(rest, o.scale)});
  if (all.empty()) throw std::invalid_argument("no scene is called " + o.scene);
  return all;
}

/// One level's frames.
struct Level {
  Accuracy accuracy;
  std::vector<double> frame_ms = {}, decide_ms = {}, host_ms = {};
  FrameResult last = {};

  void run(Detector& detector, FrameInput input) {
    input.accuracy = accuracy;
    last = {};  // its memory is the scene's again
    const auto begin = std::chrono::steady_clock::now();
    last = detector.detect(input);
    frame_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    decide_ms.push_back(stage("decide"));
    host_ms.push_back(stage("exact"));
  }
  double stage(const char* name) const {
    double sum = 0;
    for (const StageTime& stage : last.stages) sum += stage.stage == name ? stage.milliseconds : 0;
    return sum;
  }
  uint64_t contacts() const { return last.vertex_triangle.size() + last.edge_edge.size(); }
};

/// The same step again and again, at both levels in turn.
json measure(const CostlyKind& kind, Scalar scalar, const Options& o) {
  const Case& c = kind.input;
  SceneSpec spec;
  spec.device.backend = o.backend;
  spec.scalar = scalar;
  spec.threads = o.threads;
  spec.mode = kind.mode;
  spec.thickness = kind.thickness;
  const auto detector = Detector::create(spec_for(c, spec));
  detector->detect(Frame(c, spec.mode, scalar).input());
  const Frame frame(c, spec.mode, scalar, false);
  Level certified{Accuracy::kCertified}, exact{Accuracy::kExact};
  constexpr int kWarmUp = 2;
  for (int i = 0; i < kWarmUp + o.frames; ++i) {
    if (i == kWarmUp) certified = {Accuracy::kCertified}, exact = {Accuracy::kExact};
    certified.run(*detector, frame.input());
    exact.run(*detector, frame.input());
  }
  const double certified_ms = median(certified.frame_ms), exact_ms = median(exact.frame_ms);
  return {{"scene", c.name},
          {"scalar", scalar == Scalar::kF32 ? "f32" : "f64"},
          {"triangles", detector->topology().triangles.size()},
          {"contacts", exact.contacts()},
          {"uncertain", certified.contacts() - exact.contacts()},
          {"decisions", exact.last.counts.exact_decisions},
          {"certified_ms", certified_ms},
          {"exact_ms", exact_ms},
          {"ratio", exact_ms / certified_ms},
          {"decide_ms", median(exact.decide_ms)},
          {"host_ms", median(exact.host_ms)}};
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided::test;
  CLI::App app("Times whole frames at EXACT beside the same at CERTIFIED, as JSON, to standard output");
  app.footer("Real frames come from the data folder (COLLIDED_DATA).");
  Options options;
  std::string backend = "cpu", date, commit;
  app.add_option("--backend", backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--scene", options.scene, "One scene; default: all");
  app.add_flag("--costly", options.costly, "What costs EXACT the most, instead of scenes");
  app.add_option("--scale", options.scale, "Of procedural scenes: triangles grow with its square")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--frames", options.frames, "Of each level")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--threads", options.threads, "Of the host; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--date", date, "Recorded in the result");
  app.add_option("--commit", commit, "Recorded in the result");
  CLI11_PARSE(app, argc, argv);
  try {
    options.backend = backend == "cuda" ? collided::Backend::kCuda : collided::Backend::kCpu;
    json runs = json::array();
    for (const CostlyKind& kind : cases(options))
      for (const collided::Scalar scalar : kind.scalars) {
        runs.push_back(measure(kind, scalar, options));
        std::cerr << runs.back() << "\n";
      }
    std::cout << json{{"date", date},
                      {"commit", commit},
                      {"device", device_name(options.backend, options.threads)},
                      {"frames", options.frames},
                      {"runs", runs}}
                     .dump(1)
              << "\n";
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "collided_exact_bench: " << e.what() << "\n";
    return 1;
  }
}
