#pragma once
// One DetectFrame call: a frame and its answer in one message each.

#include <grpcpp/grpcpp.h>

#include <memory>

#include "server/convert/frame_intake.hpp"

namespace collided::server {

/// Runs on the scene's worker thread, and finishes the call. `scene` and what the request and response are part of live
/// until then.
void detect_frame(grpc::ServerUnaryReactor* reactor, const grpc::CallbackServerContext* context, Scene& scene,
                  PendingFrame frame, pb::DetectFrameResponse* response);

}  // namespace collided::server
