// Time, bytes on the wire and bytes on the device of each thing that a scene may declare or a frame may ask, beside a
// scene that models everything. All scenes take turns, frame by frame, so that a noisy machine is as noisy for each.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/bench/report.hpp"
#include "tests/bench/switches/variant.hpp"
#include "tests/support/case.hpp"

namespace collided::test {
namespace {

/// How far the ball has turned about z (client/scenes/cloth_ball.cpp), from the position of a vertex beside the axis.
std::vector<std::byte> pose_between(const Positions& rest, const Positions& now) {
  const auto far = std::max_element(rest.begin(), rest.end(), [](const Vec3d& a, const Vec3d& b) {
    return std::hypot(a[0], a[1]) < std::hypot(b[0], b[1]);
  });
  const Vec3d &from = *far, &to = now[static_cast<size_t>(far - rest.begin())];
  const double angle = std::atan2(to[1], to[0]) - std::atan2(from[1], from[0]);
  const double rows[12] = {std::cos(angle), -std::sin(angle), 0, 0, std::sin(angle), std::cos(angle), 0, 0, 0, 0, 1, 0};
  std::vector<std::byte> out(sizeof(rows));
  std::memcpy(out.data(), rows, sizeof(rows));
  return out;
}

/// One variant's scene, and what its frames cost.
class Run {
 public:
  Run(const Variant& variant, const Case& first, Backend backend, int threads) : variant_(variant), rest_(first.end) {
    spec_.device.backend = backend;
    spec_.scalar = Scalar::kF32;
    spec_.threads = threads;
    spec_.engine = Engine::kOctree;  // to compare engines takes time and memory of its own
    spec_.meshes = first.meshes;
    if (!variant.has_ball) spec_.meshes.pop_back();
    variant.declare(spec_);
    scene_ = Detector::create(spec_);
    detect(whole(first), false, false);
  }

  /// A cloth of which few vertices move tears in time: it does so in the frames that count alone.
  void step(const Case& c, bool is_counted) {
    const bool is_whole = variant_.send == Send::kWhole || (variant_.send == Send::kFewVertices && !is_counted);
    detect(is_whole ? whole(c) : parts(c), true, is_counted);
  }

  nlohmann::json told() const {
    uint64_t bytes = 0;
    nlohmann::json parts = nlohmann::json::object();
    for (const MemoryPart& part : scene_->memory()) bytes += part.bytes, parts[part.part] = part.bytes;
    nlohmann::json stages = nlohmann::json::object();
    for (const auto& [stage, times] : stages_) stages[stage] = median(times);
    return {{"name", variant_.name},
            {"caller_ms", median(caller_)},
            {"step_ms", median(step_)},
            {"bytes_in", median(bytes_in_)},
            {"device_bytes", bytes},
            {"contacts", last_.vertex_triangle.size() + last_.edge_edge.size()},
            {"allocations", last_.allocations},
            {"stages_ms", stages},
            {"memory", parts}};
  }

 private:
  using Send = Variant::Send;
  struct Owned {
    uint32_t mesh;
    std::vector<std::byte> end, indices, transform, start = {};
  };

  std::vector<std::byte> packed(const Positions& positions) const {
    return spec_.quantized_in ? encoded(positions, *spec_.quantized_in) : pack(positions, spec_.scalar);
  }
  std::vector<Owned> whole(const Case& c) const {
    std::vector<Owned> updates;
    for (uint32_t mesh = 0; mesh < spec_.meshes.size(); ++mesh) updates.push_back({mesh, packed(c.end[mesh]), {}, {}});
    return updates;
  }
  /// `c` begins where the last frame ended.
  std::vector<Owned> both_ends(const Case& c) const {
    std::vector<Owned> updates = whole(c);
    for (Owned& update : updates) update.start = packed(c.start[update.mesh]);
    return updates;
  }
  std::vector<Owned> parts(const Case& c) const {
    if (variant_.send == Send::kQuantized) return whole(c);
    if (variant_.send == Send::kBothEnds) return both_ends(c);
    if (variant_.send == Send::kFewVertices) return {few(c)};
    std::vector<Owned> updates = {{kCloth, packed(c.end[kCloth]), {}, {}}};
    if (variant_.send == Send::kBallByPose)
      updates.push_back({kBall, {}, {}, pose_between(rest_[kBall], c.end[kBall])});
    return updates;
  }
  /// Every twentieth vertex of the cloth.
  Owned few(const Case& c) const {
    Positions moved;
    std::vector<uint32_t> indices;
    for (uint32_t i = 0; i < c.end[kCloth].size(); i += 20) indices.push_back(i), moved.push_back(c.end[kCloth][i]);
    const auto* bytes = reinterpret_cast<const std::byte*>(indices.data());
    return {kCloth, packed(moved), {bytes, bytes + indices.size() * sizeof(uint32_t)}, {}};
  }

  void detect(const std::vector<Owned>& updates, bool is_asked, bool is_counted) {
    FrameInput input;
    double bytes = 0;
    for (const Owned& u : updates) {
      input.updates.push_back({u.mesh, u.start, u.end, !u.indices.empty(), u.indices, u.transform});
      bytes += static_cast<double>(u.start.size() + u.end.size() + u.indices.size() + u.transform.size());
    }
    if (is_asked) variant_.ask(input);
    if (is_asked && variant_.edit != Variant::Edit::kNone) input.edit = edit();
    const auto begin = std::chrono::steady_clock::now();
    last_ = scene_->detect(input);
    if (!is_counted) return;
    caller_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    step_.push_back(last_.step_milliseconds);
    bytes_in_.push_back(bytes);
    for (const StageTime& stage : last_.stages) stages_[stage.stage].push_back(stage.milliseconds);
  }

  /// Which leaves the ball what it is, so that the step is the same.
  std::shared_ptr<const SceneEdit> edit() const {
    SceneEdit edit{.meshes = {{kBall, spec_.meshes[kBall]}}};
    if (variant_.edit == Variant::Edit::kRules) edit.meshes[0].spec.triangles.clear();
    return std::make_shared<const SceneEdit>(std::move(edit));
  }

  const Variant& variant_;
  const std::vector<Positions> rest_;
  SceneSpec spec_;
  std::unique_ptr<Detector> scene_;
  FrameResult last_;
  std::vector<double> caller_, step_, bytes_in_;
  std::map<std::string, std::vector<double>> stages_;
};

void print_table(const nlohmann::json& runs) {
  const nlohmann::json& full = runs[0];
  std::cerr << "| | time, x full model | bytes in a frame | bytes held | contacts |\n|---|--:|--:|--:|--:|\n";
  for (const nlohmann::json& run : runs)
    std::cerr << "| " << run["name"].get<std::string>() << " | "
              << run["caller_ms"].get<double>() / full["caller_ms"].get<double>() << " | " << run["bytes_in"] << " | "
              << run["device_bytes"] << " | " << run["contacts"] << " |\n";
}

/// `warm_up`: frames that do not count, along the motion before the others.
nlohmann::json measure(Backend backend, double scale, int warm_up, int frames, int threads) {
  const auto scene = scenes::make_scene("cloth_ball", scale);
  const auto time = [](int frame) { return 0.6 + frame / 240.0; };
  const auto at = [&](int frame) { return case_of(*scene, time(std::max(frame - 1, -warm_up)), time(frame)); };
  std::vector<std::unique_ptr<Run>> runs;
  for (const Variant& variant : variants())
    runs.push_back(std::make_unique<Run>(variant, at(-warm_up), backend, threads));
  for (int frame = 1 - warm_up; frame <= frames; ++frame) {
    const Case c = at(frame);
    for (const auto& run : runs) run->step(c, frame > 0);
  }
  nlohmann::json told = nlohmann::json::array();
  for (const auto& run : runs) told.push_back(run->told());
  print_table(told);
  return told;
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided;
  CLI::App app(
      "Measures what each thing that a scene may declare or a frame may ask costs, as JSON, to standard output");
  std::string backend = "cpu", date, commit;
  double scale = 1;
  int frames = 30, warm_up = 70, threads = 0;
  app.add_option("--backend", backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--scale", scale, "Of the cloth and the ball: triangles grow with its square")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
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
  const Backend on = backend == "cuda" ? Backend::kCuda : Backend::kCpu;
  const nlohmann::json runs = test::measure(on, scale, warm_up, frames, threads);
  const nlohmann::json out{
      {"format", "collided switches 1"},          {"date", date},   {"commit", commit}, {"backend", backend},
      {"device", test::device_name(on, threads)}, {"scale", scale}, {"frames", frames}, {"runs", runs}};
  std::cout << out.dump(1) << '\n';
}
