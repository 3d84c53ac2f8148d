#pragma once
// The rules that a frame must meet before the engine sees it. The engine itself looks at every coordinate.

#include <cstdint>

#include "gpu/detector.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

/// Ids rise strictly, from 1. Throws InvalidInput or FailedPrecondition.
void check_frame_id(uint64_t frame_id, uint64_t last_frame_id);

/// Meshes exist, come once, have the right length; the first frame names all, later ones no static mesh.
void check_updates(const ScenePlan& plan, const FrameInput& frame, bool first);

}  // namespace collided::server
