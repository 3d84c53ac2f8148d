#pragma once
// Refuses what cannot be used before anything of the scene changes.

#include "gpu/topology.hpp"

namespace collided {

/// Throws InvalidInput for a thickness that is negative, not finite or (DCD from kFast on) 0, and for kinds all off.
void check_spec(const SceneSpec& spec);

/// Throws InvalidInput naming the update, the first bad vertex, its value and the limit.
/// `first`: no frame was applied yet, so every mesh must be named.
void check_frame(const SceneSpec& spec, const FrameInput& frame, bool first);

/// Largest magnitude of a coordinate: an eighth of the largest number, so that sums and differences stay finite.
double coordinate_limit(Scalar scalar);

inline size_t bytes_per_vertex(Scalar scalar) { return scalar == Scalar::kF64 ? 24 : 12; }

}  // namespace collided
