#pragma once
// Answers of the frame stream to the wire. The contact arrays go out from where they are; nothing is copied but heads.

#include <grpcpp/support/byte_buffer.h>

#include <vector>

#include "server/convert/convert.hpp"

namespace collided::server {

struct EncodedMessage {
  grpc::ByteBuffer bytes;
  size_t size = 0;
  bool ends_frame = false;                ///< gives a credit back
  std::shared_ptr<const void> held = {};  ///< what it takes of a limit, until it is sent
};

/// Any message whose payload is small, but for the end of a frame.
EncodedMessage encode(const pb::StreamFramesResponse& response);

/// Chunks, then the end of the frame with the last of them; each message has at most `max_chunk_bytes` of arrays.
/// Completes the cost of `frame`; the messages keep it alive as long as they refer to it.
std::vector<EncodedMessage> encode_answer(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame,
                                          size_t max_chunk_bytes);

}  // namespace collided::server
