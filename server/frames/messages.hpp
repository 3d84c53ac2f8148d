#pragma once
// What the messages of a frame stream mean on every transport.

#include "collided/v1/collision_service.pb.h"
#include "server/config/config.hpp"
#include "server/frames/session.hpp"
#include "server/refusals/status.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// What an opening asks for, checked.
struct StreamTerms {
  uint32_t window = 2;
  Delivery delivery = Delivery::kLossless;
};

/// Throws InvalidInput, LimitExceeded.
StreamTerms parse_open(const pb::OpenStream& open, const Limits& limits);

void fill_error(const Failure& failure, pb::FrameError* out);
pb::StreamFramesResponse opened_message(const Scene& scene, uint32_t window);
pb::StreamFramesResponse skipped_message(uint64_t frame_id);
pb::StreamFramesResponse draining_message(double seconds);
pb::StreamFramesResponse refusal_message(uint64_t frame_id, const Failure& failure);
/// The worlds of a set that were refused, a packet of the local socket at a time.
std::vector<pb::StreamFramesResponse> world_error_messages(const AnsweredFrame& frame);

}  // namespace collided::server
