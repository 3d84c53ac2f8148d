// What it costs to ask what is in which solid, beside a plain discrete frame: two closed meshes that overlap slightly.
// All scenes take turns, frame by frame, so that a noisy machine is as noisy for each.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/bench/report.hpp"
#include "tests/gpu/solid_shapes.hpp"

namespace collided::test {
namespace {

struct Variant {
  const char* name;
  void (*ask)(SceneSpec&);
};

void ask_for_distances(SceneSpec& spec) {
  spec.thickness = 0.01;
  spec.fields = spec.fields.with(ContactField::kNormals);
}

const Variant kVariants[] = {
    {"plain", [](SceneSpec&) {}},
    {"crossings", [](SceneSpec& spec) { spec.kinds.edge_triangle = true; }},
    {"states", [](SceneSpec& spec) { spec.pair_states = true; }},
    {"states and depths",
     [](SceneSpec& spec) {
       spec.pair_states = true;
       spec.kinds.vertex_solid = true;
     }},
    {"states and depths alone",
     [](SceneSpec& spec) {
       spec.pair_states = true;
       spec.kinds = {.vertex_solid = true};
     }},
    {"depths alone", [](SceneSpec& spec) { spec.kinds = {.vertex_solid = true}; }},
    {"within 0.01", ask_for_distances},
    {"within 0.01, signed",
     [](SceneSpec& spec) {
       ask_for_distances(spec);
       spec.fields = spec.fields.with(ContactField::kSignedDistance);
     }},
};

/// Two bumpy balls of about so many triangles each, the second one turned, so that none of its poles is up.
Case two_balls(uint64_t triangles) {
  const auto bands = static_cast<uint32_t>(std::lround(std::sqrt(static_cast<double>(triangles) / 2)));
  Shape ball = unit_ball(bands, bands);
  for (Vec3d& p : ball.positions) {
    const double r = 1 + 0.02 * std::sin(9 * p[0]) * std::sin(7 * p[1]) * std::sin(8 * p[2]);
    p = {r * p[0], r * p[1], r * p[2]};
  }
  Shape turned = ball;
  for (Vec3d& p : turned.positions) p = {p[2], 0.8 * p[0] - 0.6 * p[1], 0.6 * p[0] + 0.8 * p[1]};
  return apart({ball, turned});
}

/// The second ball overlaps the first one by 2 to 4 % of a radius.
void place(const Case& rest, Case& now, int frame) {
  const double x = 1.97 + 0.01 * std::sin(0.1 * frame);
  for (size_t i = 0; i < now.end[1].size(); ++i) {
    const Vec3d& p = rest.end[1][i];
    now.end[1][i] = {p[0] + x, p[1], p[2] + 0.1};
  }
}

class Run {
 public:
  Run(const Variant& variant, const Case& c, SceneSpec spec) : variant_(variant), spec_(std::move(spec)) {
    spec_.meshes = c.meshes;
    for (MeshSpec& mesh : spec_.meshes) mesh.solid = true;
    variant.ask(spec_);
    scene_ = Detector::create(spec_);
  }

  void step(const Case& c, bool is_counted) {
    const Frame frame(c, Mode::kDcd, spec_.scalar);
    const FrameInput input = frame.input();
    const auto begin = std::chrono::steady_clock::now();
    last_ = scene_->detect(input);
    if (!is_counted) return;
    caller_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    for (const StageTime& stage : last_.stages) stages_[stage.stage].push_back(stage.milliseconds);
  }

  nlohmann::json told() const {
    uint64_t bytes = 0;
    for (const MemoryPart& part : scene_->memory()) bytes += part.bytes;
    nlohmann::json stages = nlohmann::json::object();
    double all = 0;
    for (const auto& [stage, times] : stages_) {
      const double time = median(times);
      stages[stage] = time;
      all += stage == "upload" ? 0 : time;
    }
    return {{"name", variant_.name},
            {"caller_ms", median(caller_)},
            {"stages_sum_ms", all},
            {"stages_ms", stages},
            {"device_bytes", bytes},
            {"contacts", last_.vertex_triangle.size() + last_.edge_edge.size()},
            {"crossings", last_.edge_triangle.size()},
            {"inside", last_.vertex_solid.size()},
            {"pairs", last_.pair_states.size()}};
  }

 private:
  const Variant& variant_;
  SceneSpec spec_;
  std::unique_ptr<Detector> scene_;
  FrameResult last_;
  std::vector<double> caller_;
  std::map<std::string, std::vector<double>> stages_;
};

/// `only`: the name of a variant; empty: all.
nlohmann::json measure(const SceneSpec& spec, uint64_t triangles, const std::string& only, int warm_up, int frames) {
  const Case rest = two_balls(triangles);
  Case now = rest;
  std::vector<std::unique_ptr<Run>> runs;
  for (const Variant& variant : kVariants)
    if (only.empty() || only == variant.name) runs.push_back(std::make_unique<Run>(variant, rest, spec));
  for (int frame = -warm_up; frame < frames; ++frame) {
    place(rest, now, frame);
    for (const auto& run : runs) run->step(now, frame >= 0);
  }
  nlohmann::json told = nlohmann::json::array();
  for (const auto& run : runs) told.push_back(run->told());
  return told;
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided;
  CLI::App app("Measures what questions about solids cost, as JSON, to standard output");
  std::string backend = "cpu", date, commit, accuracy = "certified", scalar = "f32", only;
  uint64_t triangles = 100000;
  int frames = 30, warm_up = 20, threads = 0;
  app.add_option("--backend", backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--triangles", triangles, "Of each mesh, about")
      ->check(CLI::Range(uint64_t{32}, uint64_t{1} << 26))
      ->capture_default_str();
  app.add_option("--accuracy", accuracy, "certified or exact")
      ->check(CLI::IsMember({"certified", "exact"}))
      ->capture_default_str();
  app.add_option("--scalar", scalar, "f32 or f64")->check(CLI::IsMember({"f32", "f64"}))->capture_default_str();
  app.add_option("--only", only, "One variant, such as \"states and depths\"");
  app.add_option("--frames", frames, "Frames of each scene")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--warm-up", warm_up, "Frames before these, which do not count")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--threads", threads, "Of CPU scenes; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--date", date, "Recorded in the result");
  app.add_option("--commit", commit, "Recorded in the result");
  CLI11_PARSE(app, argc, argv);
  SceneSpec spec;
  spec.device.backend = backend == "cuda" ? Backend::kCuda : Backend::kCpu;
  spec.mode = Mode::kDcd;
  spec.accuracy = accuracy == "exact" ? Accuracy::kExact : Accuracy::kCertified;
  spec.scalar = scalar == "f64" ? Scalar::kF64 : Scalar::kF32;
  spec.threads = threads;
  spec.engine = Engine::kOctree;  // to compare engines takes time and memory of its own
  const nlohmann::json runs = test::measure(spec, triangles, only, warm_up, frames);
  const nlohmann::json out{{"format", "collided solids 1"},
                           {"date", date},
                           {"commit", commit},
                           {"backend", backend},
                           {"device", test::device_name(spec.device.backend, threads)},
                           {"triangles", triangles},
                           {"accuracy", accuracy},
                           {"scalar", scalar},
                           {"frames", frames},
                           {"runs", runs}};
  std::cout << out.dump(1) << '\n';
}
