#pragma once
// DetectFrame: a frame and its answer in one message each.

#include <memory>

#include "server/scenes/scene_host.hpp"
#include "server/transport/grpc/unary_call.hpp"

namespace collided::server {

/// Admits the frame and posts it to the scene's worker, which ends the call. `held` is kept alive until then. Throws
/// NotFound, LimitExceeded if too many frames of the scene wait.
void detect_frame(UnaryCall<pb::DetectFrameRequest, pb::DetectFrameResponse>& call, SceneHost& host,
                  const std::shared_ptr<void>& held);

}  // namespace collided::server
