#pragma once
// Refuses what cannot be used before anything of the scene changes.

#include "gpu/topology.hpp"

namespace collided {

/// What holds for one frame: its own options, or else the scene's.
struct FrameSettings {
  Accuracy accuracy;
  double delta;
  Report report;
};
inline FrameSettings settings_of(const SceneSpec& spec, const FrameInput& frame) {
  return {frame.accuracy.value_or(spec.accuracy), frame.delta.value_or(spec.delta), frame.report.value_or(spec.report)};
}

/// Throws InvalidInput for a thickness or delta that is negative or not finite, for a thickness of 0 in DCD at kFast,
/// for kinds all off, triangle pairs in CCD, and reports that the mode or the accuracy does not have.
void check_spec(const SceneSpec& spec);

/// Throws InvalidInput naming the update, the first bad vertex, its value and the limit, or the frame's option that
/// the scene cannot have.
/// `first`: no frame was applied yet, so every mesh must be named.
void check_frame(const SceneSpec& spec, const FrameInput& frame, bool first);

/// Largest magnitude of a coordinate: an eighth of the largest number, so that sums and differences stay finite.
double coordinate_limit(Scalar scalar);

inline size_t bytes_per_vertex(Scalar scalar) { return scalar == Scalar::kF64 ? 24 : 12; }

}  // namespace collided
