// Frames that resemble the last: steps that may go by lists of neighbours beside steps that always search.

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/bench/report.hpp"
#include "tests/support/case.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

using nlohmann::json;

struct Options {
  Backend backend = Backend::kCpu;
  std::string scene, reuse = "auto";
  int frames = 1000, threads = 0;
  double scale = 1, motion = 0.05;
};

/// A scene whose fastest vertex moves by a share of the mean edge in each frame, back and forth through its middle.
class Motion {
 public:
  Motion(const std::string& name, const Options& o) : scene_(scenes::make_scene(name, o.scale)) {
    const double edge = mean_edge(), far = fastest(kProbe);
    step_ = far > 0 ? kProbe * o.motion * edge / far : kProbe;
    for (int i = 0; i < kRefinements; ++i)
      if (const double moved = fastest(step_); moved > o.motion * edge) step_ *= o.motion * edge / moved;
  }
  /// Frame 0 ends where it begins.
  Case at(int frame) const { return case_of(*scene_, time_at(std::max(frame - 1, 0)), time_at(frame)); }
  double step() const { return step_; }

 private:
  static constexpr double kFirst = 0.35, kLast = 0.9, kProbe = 1e-4;
  static constexpr int kRefinements = 3, kSamples = 16;

  double time_at(int frame) const {
    const double span = kLast - kFirst, way = std::fmod(frame * step_, 2 * span);
    return kFirst + (way < span ? way : 2 * span - way);
  }
  double mean_edge() const {
    const std::vector<scenes::Vec3d> at = scene_->positions(kFirst);
    double sum = 0;
    uint64_t count = 0;
    uint32_t first = 0;
    for (const scenes::Mesh& mesh : scene_->meshes()) {
      for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k, ++count) sum += distance(at[first + t[k]], at[first + t[(k + 1) % 3]]);
      first += mesh.vertex_count;
    }
    return sum / static_cast<double>(count);
  }
  /// Largest way of a vertex in `dt`, of some times.
  double fastest(double dt) const {
    double far = 0;
    for (int i = 0; i < kSamples; ++i) {
      const double t = kFirst + (kLast - kFirst) * i / kSamples;
      const auto before = scene_->positions(t), after = scene_->positions(t + dt);
      for (size_t v = 0; v < before.size(); ++v) far = std::max(far, distance(before[v], after[v]));
    }
    return far;
  }
  static double distance(const scenes::Vec3d& a, const scenes::Vec3d& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }

  std::unique_ptr<scenes::Scene> scene_;
  double step_ = 0;
};

/// One way of finding candidates, over all frames.
struct Side {
  std::unique_ptr<Detector> detector;
  double step_ms = 0, frame_ms = 0;
  uint64_t uses[3] = {0, 0, 0};  ///< steps by ListUse
  double use_ms[3] = {0, 0, 0};
  FrameResult last = {};

  void run(const FrameInput& input, bool counts) {
    last = {};
    const auto begin = std::chrono::steady_clock::now();
    last = detector->detect(input);
    if (!counts) return;
    frame_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    step_ms += last.step_milliseconds;
    const int use = static_cast<int>(last.reuse.use);
    ++uses[use];
    use_ms[use] += last.step_milliseconds;
  }
  uint64_t list_bytes() const {
    uint64_t bytes = 0;
    for (const MemoryPart& part : detector->memory()) bytes += part.part == "neighbours" ? part.bytes : 0;
    return bytes;
  }
  json mean(ListUse use) const {
    const int i = static_cast<int>(use);
    return uses[i] > 0 ? json(use_ms[i] / static_cast<double>(uses[i])) : json();
  }
  json stages() const {
    json stages;
    for (const StageTime& stage : last.stages) stages[stage.stage] = stage.milliseconds;
    return stages;
  }
};

Side side(const Case& c, const Options& o, Reuse reuse) {
  SceneSpec spec;
  spec.device.backend = o.backend;
  spec.threads = o.threads;
  spec.reuse = reuse;
  return {.detector = Detector::create(spec_for(c, spec))};
}

/// Both sides in turn, each first every other time; their contacts are the same bytes.
json measure(const std::string& name, const Options& o) {
  constexpr int kWarmUp = 3;
  const Motion motion(name, o);
  const Case first = motion.at(0);
  const Mode mode = Mode::kCcd;
  Side off = side(first, o, Reuse::kOff), reuse = side(first, o, o.reuse == "on" ? Reuse::kOn : Reuse::kAuto);
  for (int i = 0; i < kWarmUp + o.frames; ++i) {
    const Frame frame(motion.at(i), mode, Scalar::kF32, i == 0);
    for (Side* s : i % 2 == 0 ? std::array{&off, &reuse} : std::array{&reuse, &off})
      s->run(frame.input(), i >= kWarmUp);
    if (!same_contacts(off.last, reuse.last) || off.last.earliest_toi != reuse.last.earliest_toi)
      throw std::runtime_error(name + ": frame " + std::to_string(i) + " has other contacts with lists");
  }
  return {{"scene", name},
          {"triangles", off.detector->topology().triangles.size()},
          {"frames", o.frames},
          {"time_step", motion.step()},
          {"contacts", count_contacts(off.last)},
          {"search_step_ms", off.step_ms / o.frames},
          {"reuse_step_ms", reuse.step_ms / o.frames},
          {"step_ratio", reuse.step_ms / off.step_ms},
          {"frame_ratio", reuse.frame_ms / off.frame_ms},
          {"searched", reuse.uses[0]},
          {"made", reuse.uses[1]},
          {"reused", reuse.uses[2]},
          {"searched_ms", reuse.mean(ListUse::kNone)},
          {"made_ms", reuse.mean(ListUse::kMade)},
          {"reused_ms", reuse.mean(ListUse::kReused)},
          {"margin", reuse.last.reuse.margin},
          {"list_bytes", reuse.list_bytes()},
          {"last_search_stages", off.stages()},
          {"last_reuse_stages", reuse.stages()}};
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided::test;
  CLI::App app(
      "Times steps that may go by lists of neighbours beside steps that always search, as JSON, to standard output");
  Options options;
  std::string backend = "cpu", date, commit;
  app.add_option("--backend", backend, "cpu or cuda")->check(CLI::IsMember({"cpu", "cuda"}))->capture_default_str();
  app.add_option("--scene", options.scene, "One procedural scene; default: cloth_ball, nbody and reef_knot");
  app.add_option("--scale", options.scale, "Triangles grow with its square")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--frames", options.frames, "Of each scene")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--motion", options.motion, "Of the fastest vertex in a frame, in mean edges")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--reuse", options.reuse, "auto or on")->check(CLI::IsMember({"auto", "on"}))->capture_default_str();
  app.add_option("--threads", options.threads, "Of the host; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--date", date, "Recorded in the result");
  app.add_option("--commit", commit, "Recorded in the result");
  CLI11_PARSE(app, argc, argv);
  try {
    options.backend = backend == "cuda" ? collided::Backend::kCuda : collided::Backend::kCpu;
    std::vector<std::string> scenes = {"cloth_ball", "nbody", "reef_knot"};
    if (!options.scene.empty()) scenes = {options.scene};
    json runs = json::array();
    for (const std::string& scene : scenes) {
      runs.push_back(measure(scene, options));
      std::cerr << runs.back() << "\n";
    }
    std::cout << json{{"date", date},
                      {"commit", commit},
                      {"device", device_name(options.backend, options.threads)},
                      {"motion", options.motion},
                      {"runs", runs}}
                     .dump(1)
              << "\n";
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "collided_reuse_bench: " << e.what() << "\n";
    return 1;
  }
}
