#pragma once
// One frame from its positions to its contacts, whichever way it came.

#include <functional>

#include "server/frames/frame.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

/// Waits for a turn and applies the frame, on the scene's worker thread; on CPU cores it gives way to other clients
/// from time to time. Throws the frame's refusal, what the engine throws, Cancelled, and LimitExceeded for a frame that
/// runs longer than its client's frames may.
AnsweredFrame run_frame(Scene& scene, PendingFrame& frame, const std::function<bool()>& cancelled);

}  // namespace collided::server
