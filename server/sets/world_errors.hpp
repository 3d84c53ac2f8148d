#pragma once
// Why frames of single worlds of a set were refused, in the protocol's terms.

#include <string>

#include "collided/v1/frame.pb.h"
#include "gpu/detector.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Refused worlds of an answer that have a message and a field.
constexpr size_t kMaxWorldMessages = 256;
/// Bytes of a message with them, and without.
constexpr uint64_t kWorldErrorBytes = 512, kBareWorldErrorBytes = 16;

/// Where a request has a frame, and its positions: "frame" and "frame.updates[0]".
struct SetFramePaths {
  std::string frame, positions;
};

/// `index`: of the world among those that were refused.
void fill_world_error(const RefusedWorld& refused, size_t index, const SetFramePaths& paths, pb::WorldError* out);

}  // namespace collided::server
