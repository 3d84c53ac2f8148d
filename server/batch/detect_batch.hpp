#pragma once
// DetectBatch: frames of sets of worlds and their answers in one message each.

#include <memory>

#include "server/scenes/scene_host.hpp"
#include "server/transport/grpc/unary_call.hpp"

namespace collided::server {

/// Admits the frames and posts each to its set's worker; the last that is done ends the call. `held` is kept alive
/// until then. Throws InvalidInput, LimitExceeded for a request that no frame of is tried.
void detect_batch(UnaryCall<pb::DetectBatchRequest, pb::DetectBatchResponse>& call, SceneHost& host,
                  const std::shared_ptr<void>& held);

}  // namespace collided::server
