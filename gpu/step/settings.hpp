#pragma once
// The options that a frame is computed with.

#include "gpu/types.hpp"

namespace collided {

/// What holds for one frame: its own options, or else the scene's.
struct FrameSettings {
  Accuracy accuracy;
  double delta;
  Report report;

  bool operator==(const FrameSettings&) const = default;
};
inline FrameSettings settings_of(const SceneSpec& spec, const FrameInput& frame) {
  return {frame.accuracy.value_or(spec.accuracy), frame.delta.value_or(spec.delta), frame.report.value_or(spec.report)};
}

}  // namespace collided
