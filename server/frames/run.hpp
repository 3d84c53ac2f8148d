#pragma once
// One frame from its positions to its contacts, on any transport.

#include <cstdint>
#include <exception>
#include <functional>

#include "server/frames/frame.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

/// Waits for a turn and applies the frame, on the scene's worker thread; on CPU cores it yields to other clients after
/// each quantum. Throws the frame's refusal, what the engine throws, Cancelled, and LimitExceeded for a frame that runs
/// longer than its client's frames may.
AnsweredFrame run_frame(Scene& scene, PendingFrame& frame, const std::function<bool()>& cancelled);

/// Why a frame that ran has no answer, where making it failed because of `why`.
std::exception_ptr unanswered(uint64_t frame_id, bool is_trial, const std::exception_ptr& why);

}  // namespace collided::server
