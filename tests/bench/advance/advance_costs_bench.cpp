// Compares the cost of a frame that advances with that of the same frame without an advance. Writes JSON. Each round
// plays the plain frame, then the frame in each mode, from the same positions, in a scene for each.

#include <CLI/CLI.hpp>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/bench/inputs.hpp"
#include "tests/bench/report.hpp"

namespace collided::test {
namespace {

using nlohmann::json;

struct Options {
  Backend backend = Backend::kCpu;
  Scalar scalar = Scalar::kF64;
  Accuracy accuracy = Accuracy::kCertified;
  std::string scene;
  int rounds = 30, warm_up = 4, threads = 0;
  double scale = 1, separation = 1e-4, seconds = kFrameSeconds;
};

/// A way to play a frame, and what it cost: the whole call, the backend's part, and the advance's part of that.
struct Side {
  std::string name;
  bool advances = true;
  AdvanceMode mode = AdvanceMode::kAllOrOne;
  std::unique_ptr<Detector> detector = {};
  std::vector<double> frame_ms = {}, step_ms = {}, advance_ms = {};
  FrameResult last = {};

  void play(FrameInput frame, bool counts) {
    frame.advance = advances;
    frame.advance_mode = mode;
    const auto begin = std::chrono::steady_clock::now();
    last = detector->detect(frame);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    if (!counts) return;
    frame_ms.push_back(took.count());
    step_ms.push_back(last.step_milliseconds);
    for (const StageTime& stage : last.stages)
      if (stage.stage == "advance") advance_ms.push_back(stage.milliseconds);
  }
};

json measure(const BenchInput& input, const Options& o) {
  const Case way = input.at(0, 1);
  SceneSpec spec;
  spec.device.backend = o.backend;
  spec.scalar = o.scalar;
  spec.accuracy = o.accuracy;
  spec.threads = o.threads;
  spec.engine = Engine::kOctree;
  spec.min_separation = o.separation;
  Side sides[] = {{.name = "plain", .advances = false},
                  {.name = "all_or_one"},
                  {.name = "per_mesh", .mode = AdvanceMode::kPerMesh},
                  {.name = "per_vertex", .mode = AdvanceMode::kPerVertex}};
  for (Side& side : sides) side.detector = Detector::create(spec_for(way, spec));
  const Frame first(way, Mode::kCcd, o.scalar), frame(way, Mode::kCcd, o.scalar, false);
  for (int i = -o.warm_up; i < o.rounds; ++i)
    for (Side& side : sides) side.play(i == -o.warm_up ? first.input() : frame.input(), i >= 0);
  const double plain = median(sides[0].step_ms), plain_frame = median(sides[0].frame_ms);
  json out = {{"scene", input.name},
              {"triangles", sides[0].detector->topology().triangles.size()},
              {"min_separation", o.separation},
              {"seconds", o.seconds},
              {"rounds", o.rounds},
              {"contacts", sides[0].last.vertex_triangle.size() + sides[0].last.edge_edge.size()},
              {"sides", json::object()}};
  for (const Side& side : sides) {
    json& told = out["sides"][side.name] = {{"step_ms", median(side.step_ms)},
                                            {"ratio", median(side.step_ms) / plain},
                                            {"frame_ms", median(side.frame_ms)},
                                            {"frame_ratio", median(side.frame_ms) / plain_frame}};
    if (!side.advances) continue;
    told["advance_ms"] = median(side.advance_ms);
    told["advanced"] = side.last.advanced.value_or(1);
    told["way"] = side.last.way;
    told["shortened"] = side.last.shortened.ids.size();
  }
  std::cerr << out.dump() << '\n';
  return out;
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided;
  CLI::App app("Measures frames that advance beside plain ones, and writes JSON to standard output");
  test::Options o;
  std::string backend = "cpu", scalar = "f64", accuracy = "certified", date, commit;
  app.add_option("--backend", backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--scalar", scalar, "f32 or f64")->check(CLI::IsMember({"f32", "f64"}))->capture_default_str();
  app.add_option("--accuracy", accuracy, "certified or exact")
      ->check(CLI::IsMember({"certified", "exact"}))
      ->capture_default_str();
  app.add_option("--scene", o.scene, "One scene; default: all, and real frames");
  app.add_option("--scale", o.scale, "Of procedural scenes")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--seconds", o.seconds,
                 "How long procedural scenes move in a frame: short enough, nothing is shortened")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--separation", o.separation, "min_separation")->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--rounds", o.rounds, "Frames of each kind")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--threads", o.threads, "CPU threads; 0: all cores")->capture_default_str();
  app.add_option("--date", date, "Recorded in the result");
  app.add_option("--commit", commit, "Recorded in the result");
  CLI11_PARSE(app, argc, argv);
  o.backend = backend == "cuda" ? Backend::kCuda : Backend::kCpu;
  o.scalar = scalar == "f32" ? Scalar::kF32 : Scalar::kF64;
  o.accuracy = accuracy == "exact" ? Accuracy::kExact : Accuracy::kCertified;
  nlohmann::json out{{"format", "collided advance costs 1"},
                     {"date", date},
                     {"commit", commit},
                     {"device", test::device_name(o.backend, o.threads)},
                     {"scalar", scalar},
                     {"accuracy", accuracy},
                     {"runs", nlohmann::json::array()}};
  for (const test::BenchInput& input : test::bench_inputs(o.scene, o.scale, o.seconds))
    out["runs"].push_back(test::measure(input, o));
  std::cout << out.dump(1) << '\n';
}
