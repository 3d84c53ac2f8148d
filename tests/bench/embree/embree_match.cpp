#include "tests/bench/embree/embree_match.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>

#include "tests/bench/embree/embree_collider.hpp"

namespace collided::test {
namespace {

// The boxes of the engine at F32: of the rounded positions at t = 0 and 1, not inflated.
FloatBox swept_box(const std::array<uint32_t, 3>& triangle, const Positions& start, const Positions& end) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  FloatBox box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const uint32_t v : triangle)
    for (const Positions* positions : {&start, &end})
      for (int k = 0; k < 3; ++k) {
        const float x = static_cast<float>((*positions)[v][k]);
        box.lo[k] = std::min(box.lo[k], x);
        box.hi[k] = std::max(box.hi[k], x);
      }
  return box;
}

std::vector<FloatBox> swept_boxes(const Case& c) {
  std::vector<FloatBox> boxes;
  for (size_t m = 0; m < c.meshes.size(); ++m)
    for (const auto& triangle : c.meshes[m].triangles) boxes.push_back(swept_box(triangle, c.start[m], c.end[m]));
  return boxes;
}

// What the boxes do not say about a pair of triangles.
class PairRules {
 public:
  PairRules(const Topology& topology, const Case& c) : triangles_(topology.triangles) {
    for (const MeshSpec& mesh : c.meshes)
      is_static_.insert(is_static_.end(), mesh.triangles.size(), mesh.motion == MeshMotion::kStatic);
  }
  bool may_touch(uint32_t a, uint32_t b) const { return !is_static_[a] || !is_static_[b]; }
  bool are_apart(uint32_t a, uint32_t b) const {
    const auto &p = triangles_[a], &q = triangles_[b];
    return std::find_first_of(p.begin(), p.end(), q.begin(), q.end()) == p.end();
  }

 private:
  const std::vector<std::array<uint32_t, 3>>& triangles_;
  std::vector<char> is_static_;  // of each triangle
};

// The engine on the case, its meshes in place.
class EngineSide {
 public:
  EngineSide(const Case& c, SceneSpec settings)
      : detector_(Detector::create(spec_for(c, std::move(settings)))), frame_(c, Mode::kCcd, Scalar::kF32, false) {
    result_ = detector_->detect(Frame(c, Mode::kCcd, Scalar::kF32).input());  // static meshes come once
  }
  const FrameResult& run() { return result_ = detector_->detect(frame_.input()); }
  const FrameResult& result() const { return result_; }
  const Topology& topology() const { return detector_->topology(); }

 private:
  std::unique_ptr<Detector> detector_;
  Frame frame_;
  FrameResult result_;
};

SceneSpec candidates_spec(int threads) {
  SceneSpec spec;
  spec.accuracy = Accuracy::kCandidates;
  spec.threads = threads;
  return spec;
}

// nullopt if the engine does not list the triangle pairs of a step.
std::unique_ptr<EngineSide> triangle_pairs_side(const Case& c, int threads) {
  SceneSpec spec = candidates_spec(threads);
  spec.kinds.vertex_triangle = spec.kinds.edge_edge = false;
  spec.kinds.triangle_triangle = true;
  try {
    return std::make_unique<EngineSide>(c, spec);
  } catch (const InvalidInput&) {
    return nullptr;
  }
}

// From resident positions to a list in canonical order.
double step_milliseconds(const FrameResult& result) {
  if (result.step_milliseconds > 0) return result.step_milliseconds;
  double sum = 0;
  for (const StageTime& s : result.stages)
    if (s.stage != "upload" && !s.stage.starts_with("download")) sum += s.milliseconds;
  return sum;
}

template <class Work>
double milliseconds(Work&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void run_round(EmbreeCollider& collider, Contender& contender) {
  contender.build_ms.push_back(milliseconds([&] { collider.build(); }));
  contender.ms.push_back(contender.build_ms.back() + milliseconds([&] { collider.collide(); }));
}

void run_round(EngineSide& side, Contender& contender) { contender.ms.push_back(step_milliseconds(side.run())); }

void forget(Contender& contender) {
  contender.ms.clear();
  contender.build_ms.clear();
}

void compare_counts(Match& match, EmbreeCollider& collider, const EngineSide& candidates, const EngineSide* pairs,
                    const PairRules& rules) {
  match.embree_pairs = collider.collide([&](uint32_t a, uint32_t b) { return rules.may_touch(a, b); });
  match.embree_pairs_apart =
      collider.collide([&](uint32_t a, uint32_t b) { return rules.may_touch(a, b) && rules.are_apart(a, b); });
  match.engine_pairs = candidates.result().counts.pairs;
  match.candidates_vt = candidates.result().counts.candidates.vertex_triangle;
  match.candidates_ee = candidates.result().counts.candidates.edge_edge;
  match.lists_pairs = pairs != nullptr;
  if (pairs != nullptr) match.listed_pairs = pairs->result().triangle_triangle.size();
}

}  // namespace

Match run_match(const Case& c, int rounds, int threads) {
  constexpr int kWarmUp = 2;  // buffers grow, and the engine may choose its broad phase by what the last frames cost
  const std::vector<FloatBox> boxes = swept_boxes(c);
  EmbreeCollider low(boxes, RTC_BUILD_QUALITY_LOW, threads), medium(boxes, RTC_BUILD_QUALITY_MEDIUM, threads);
  EngineSide candidates(c, candidates_spec(threads));
  const std::unique_ptr<EngineSide> pairs = triangle_pairs_side(c, threads);

  Match match;
  match.triangles = boxes.size();
  match.contenders = {{"Embree, quality low (Morton)", true},
                      {"Embree, quality medium (SAH)", true},
                      {"collided, triangle pairs"},
                      {"collided, VT + EE candidates"}};
  for (int round = -kWarmUp; round < rounds; ++round) {
    if (round == 0) std::for_each(match.contenders.begin(), match.contenders.end(), forget);
    run_round(low, match.contenders[0]);
    run_round(medium, match.contenders[1]);
    if (pairs) run_round(*pairs, match.contenders[2]);
    run_round(candidates, match.contenders[3]);
  }
  compare_counts(match, low, candidates, pairs.get(), PairRules(candidates.topology(), c));
  return match;
}

}  // namespace collided::test
