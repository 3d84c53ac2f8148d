#pragma once
// The options that a frame is computed with.

#include "gpu/types.hpp"

namespace collided {

/// What holds for one frame: its own options, or else the scene's.
struct FrameSettings {
  Accuracy accuracy;
  double delta;
  Report report;
  double thickness;        ///< of contacts; CCD: at t = 1
  double start_thickness;  ///< CCD from kGuarded on: at t = 0, growing linearly to `thickness`
  bool ignore_separating;  ///< for all but the list of all contacts

  bool operator==(const FrameSettings&) const = default;
};
inline FrameSettings settings_of(const SceneSpec& spec, const FrameInput& frame) {
  return {frame.accuracy.value_or(spec.accuracy),
          frame.delta.value_or(spec.delta),
          frame.report.value_or(spec.report),
          spec.thickness,
          spec.thickness,
          frame.ignore_separating || frame.advance};
}

}  // namespace collided
