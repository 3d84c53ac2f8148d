#pragma once
// Answers of the frame stream to the wire. The contact arrays are sent from where they lie; only heads are copied.

#include <grpcpp/support/byte_buffer.h>

#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/frames/frame.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

namespace pb = collided::v1;

struct EncodedMessage {
  grpc::ByteBuffer bytes;
  size_t size = 0;
  bool ends_frame = false;                ///< gives a credit back
  std::shared_ptr<const void> held = {};  ///< what it takes of a limit until it is sent
};

/// Any message with a small payload, but not the end of an answer.
EncodedMessage encode(const pb::StreamFramesResponse& response);

/// Chunks, then the end of the answer with the last of them; each message has at most `max_chunk_bytes` of arrays.
/// Completes the cost of `frame`; the messages keep it alive as long as they refer to it.
std::vector<EncodedMessage> encode_answer(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame,
                                          size_t max_chunk_bytes);

}  // namespace collided::server
