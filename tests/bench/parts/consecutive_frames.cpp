#include "tests/bench/parts/consecutive_frames.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

constexpr Scalar kScalar = Scalar::kF32;

/// make(i) for each of so many, on a few threads: positions of one frame may take a GB while they are made.
template <class Make>
void make_each(size_t count, const Make& make) {
  constexpr unsigned kMost = 8;
  std::atomic<size_t> next = 0;
  std::vector<std::jthread> makers;
  for (unsigned k = 0; k < std::clamp(std::thread::hardware_concurrency(), 1u, kMost); ++k)
    makers.emplace_back([&] {
      for (size_t i; (i = next++) < count;) make(i);
    });
}

class ProceduralFrames final : public ConsecutiveFrames {
 public:
  ProceduralFrames(const scenes::Scene& scene, const Pace& pace)
      : first_(case_of(scene, std::max(0.0, pace.end_of(0) - pace.step_seconds), pace.end_of(0))),
        first_frame_(first_, Mode::kCcd, kScalar),
        ends_(pace.frames - 1) {
    first_.start.clear(), first_.end.clear();
    make_each(ends_.size(), [&](size_t i) { ends_[i] = pack(scene.positions(pace.end_of(i + 1)), kScalar); });
  }
  const std::vector<MeshSpec>& meshes() const override { return first_.meshes; }
  size_t count() const override { return ends_.size() + 1; }
  FrameInput input(size_t i) const override {
    if (i == 0) return first_frame_.input();
    FrameInput input;
    std::span<const std::byte> left = ends_[i - 1];
    for (uint32_t m = 0; m < first_.meshes.size(); ++m) {
      const auto of_mesh = left.first(size_t{first_.meshes[m].vertex_count} * 3 * sizeof(float));
      left = left.subspan(of_mesh.size());
      if (first_.meshes[m].motion != MeshMotion::kStatic) input.updates.push_back({.mesh = m, .end = of_mesh});
    }
    return input;
  }

 private:
  Case first_;  ///< without positions
  Frame first_frame_;
  std::vector<std::vector<std::byte>> ends_;  ///< of all meshes, of each later frame
};

class RepeatedFrames final : public ConsecutiveFrames {
 public:
  RepeatedFrames(Case pair, size_t frames)
      : pair_(std::move(pair)),
        first_(pair_, Mode::kCcd, kScalar),
        later_(pair_, Mode::kCcd, kScalar, false),
        frames_(frames) {}
  const std::vector<MeshSpec>& meshes() const override { return pair_.meshes; }
  size_t count() const override { return frames_; }
  FrameInput input(size_t i) const override { return i == 0 ? first_.input() : later_.input(); }

 private:
  Case pair_;
  Frame first_, later_;
  size_t frames_;
};

}  // namespace

double Pace::end_of(size_t i) const {
  const double all = step_seconds * static_cast<double>(frames);
  const double begin = std::clamp(1 - all, 0.0, 0.8);
  const double t = std::fmod(begin + step_seconds * static_cast<double>(i + 1), 2);
  return t <= 1 ? t : 2 - t;
}

std::unique_ptr<ConsecutiveFrames> consecutive_frames(const std::string& scene, double scale, const Pace& pace) {
  if (is_procedural(scene)) return std::make_unique<ProceduralFrames>(*scenes::make_scene(scene, scale), pace);
  for (const RealFrames& frames : frames_of_data_folder())
    if (frames.name == scene) return std::make_unique<RepeatedFrames>(load(frames), pace.frames);
  return nullptr;
}

std::vector<std::string> names_of_scenes() {
  std::vector<std::string> names = scene_names();
  for (const RealFrames& frames : frames_of_data_folder()) names.emplace_back(frames.name);
  return names;
}

}  // namespace collided::test
