#pragma once
// One DetectFrame call: a frame and its answer in one message each.

#include "server/convert/frame_intake.hpp"
#include "server/service/unary_call.hpp"

namespace collided::server {

/// Runs on the scene's worker thread, and finishes the call. `scene` lives until then.
void detect_frame(UnaryCall<pb::DetectFrameRequest, pb::DetectFrameResponse>& call, Scene& scene, PendingFrame frame);

}  // namespace collided::server
