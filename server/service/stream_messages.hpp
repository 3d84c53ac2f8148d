#pragma once
// What the messages of a frame stream mean on every transport.

#include "server/convert/convert.hpp"
#include "server/scenes/frame_session.hpp"
#include "server/service/status.hpp"

namespace collided::server {

/// A checked opening.
struct OpenedStream {
  uint32_t window = 2;
  Delivery delivery = Delivery::kLossless;
};

/// Throws InvalidInput, LimitExceeded.
OpenedStream parse_open(const pb::OpenStream& open, const Limits& limits);

pb::StreamFramesResponse opened_message(const Scene& scene, uint32_t window);
pb::StreamFramesResponse skipped_message(uint64_t frame_id);
pb::StreamFramesResponse draining_message(double seconds);
pb::StreamFramesResponse refusal_message(uint64_t frame_id, const Failure& failure);

}  // namespace collided::server
