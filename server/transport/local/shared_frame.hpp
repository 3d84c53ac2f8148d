#pragma once
// A frame whose positions are in shared memory.

#include "collided/v1/local.pb.h"
#include "server/frames/intake.hpp"
#include "server/transport/local/shared_region.hpp"

namespace collided::server {

/// Resolves the ranges of a frame to memory, for admit_frame(), and removes them from the message. `region` may be
/// null. An invalid range becomes the frame's refusal.
void place_ranges(const SharedRegion* region, IncomingFrame& frame);

/// Reads a frame whose message itself is in the region, for a scene of this plan. `copied` takes the bytes of the
/// message meanwhile. Throws InvalidInput, LimitExceeded, and what the quota throws.
pb::Frame read_frame(const SharedRegion* region, const pb::SharedRange& range, const ScenePlan& plan,
                     MemoryHold& copied);

}  // namespace collided::server
