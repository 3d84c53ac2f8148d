#pragma once
// What a scene may declare or a frame may ask, one thing at a time, beside a scene that models everything: a cloth that
// falls over a ball that turns, all of it deformable.

#include <string>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::test {

constexpr uint32_t kCloth = 0, kBall = 1;

struct Variant {
  std::string name = "";
  enum class Send { kWhole, kBothEnds, kClothAlone, kBallByPose, kFewVertices, kQuantized };
  Send send = Send::kWhole;
  void (*declare)(SceneSpec&) = [](SceneSpec&) {};
  void (*ask)(FrameInput&) = [](FrameInput&) {};
  bool has_ball = true;
  /// What each frame changes: nothing, the rules of the ball alone, or the ball itself.
  enum class Edit { kNone, kRules, kBall };
  Edit edit = Edit::kNone;
};

/// The first is the full model, and the next ones are compared with it.
const std::vector<Variant>& variants();

}  // namespace collided::test
