#pragma once
// Which options go together: the one place of these rules.

#include "gpu/step/settings.hpp"

namespace collided {

/// Throws InvalidInput for a thickness, delta or min_separation that is negative or not finite, for a thickness of 0 in
/// DCD at kFast, for kinds all off, triangle pairs in CCD, and reports that the mode or the accuracy does not have.
void check_spec(const SceneSpec& spec);

/// Throws InvalidInput naming the frame's option that the scene cannot have.
void check_frame(const SceneSpec& spec, const FrameInput& frame);

/// Whether some pair of meshes may not touch.
bool needs_pair_filter(const SceneSpec& spec);

}  // namespace collided
