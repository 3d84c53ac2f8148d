#pragma once
// A frame whose positions are in shared memory.

#include "collided/v1/local.pb.h"
#include "server/convert/frame_intake.hpp"
#include "server/local/shared_region.hpp"

namespace collided::server {

/// Names where the positions lie, for admit_frame(), and takes the ranges out of the message. `region` may be null.
/// What is wrong with a range becomes the frame's refusal.
void place_ranges(const SharedRegion* region, IncomingFrame& frame);

/// The message that lies in the region itself, for a scene of so many meshes, of at most `most` bytes. Throws
/// InvalidInput, LimitExceeded.
pb::Frame read_frame(const SharedRegion* region, const pb::SharedRange& range, size_t meshes, uint64_t most);

}  // namespace collided::server
