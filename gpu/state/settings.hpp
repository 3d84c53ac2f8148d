#pragma once
// The options that a frame is computed with.

#include <algorithm>

#include "gpu/base/half_thickness.hpp"
#include "gpu/types.hpp"

namespace collided {

/// What holds for one frame: its own options, or else the scene's.
struct FrameSettings {
  Mode mode;  ///< kDcd or kCcd
  Accuracy accuracy;
  double delta;
  Report report;
  double thickness;        ///< of contacts; CCD: at t = 1
  double start_thickness;  ///< CCD from kGuarded on: at t = 0, growing linearly to `thickness`
  bool ignore_separating;  ///< for all but the list of all contacts
  double encoding = 0;     ///< what two features may be closer than their positions say, which were encoded
  double thickest = 0;     ///< the largest half thickness of a mesh; 0: half thicknesses do not count

  bool operator==(const FrameSettings&) const = default;
  bool is_ccd() const { return mode == Mode::kCcd; }
  /// Meshes are thick by themselves, so that pairs differ in their contact distances.
  bool differs_by_pair() const { return thickest > 0; }
  /// What positions have to be farther apart than, for the features to be apart by the thickness.
  double reach() const { return Deviations::widened(thickness, encoding); }
  /// The same for the features of any two meshes.
  double reach_of_any_pair() const { return ContactDistance(reach(), thickest, thickest).above(); }
};

/// Returns the largest half thickness of a mesh.
inline double thickest_of(const SceneSpec& spec) {
  double thickest = 0;
  for (const MeshSpec& mesh : spec.meshes) thickest = std::max(thickest, mesh.half_thickness);
  return thickest;
}
inline FrameSettings settings_of(const SceneSpec& spec, const FrameInput& frame) {
  const Mode mode = frame.mode.value_or(spec.mode == Mode::kDcd ? Mode::kDcd : Mode::kCcd);
  const double thickness = spec.mode == Mode::kBoth && mode == Mode::kCcd ? spec.min_separation : spec.thickness;
  const bool counts_halves = spec.mode != Mode::kBoth || mode == Mode::kDcd;
  return {mode,
          frame.accuracy.value_or(spec.accuracy),
          frame.delta.value_or(spec.delta),
          frame.report.value_or(spec.report),
          thickness,
          thickness,
          frame.ignore_separating || frame.advance,
          0,
          counts_halves ? thickest_of(spec) : 0};
}

}  // namespace collided
