#pragma once
// The options that a frame is computed with.

#include "gpu/base/deviations.hpp"
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
  double encoding = 0;     ///< what two features may be closer than their positions say, which were encoded

  bool operator==(const FrameSettings&) const = default;
  /// What positions have to be farther apart than, for the features to be apart by the thickness.
  double reach() const { return Deviations::widened(thickness, encoding); }
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
