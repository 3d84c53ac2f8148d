#pragma once
// Encodes answers of the frame stream. Contact arrays are sent in place; only heads are copied.

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
  bool ends_frame = false;                ///< returns a credit
  std::shared_ptr<const void> held = {};  ///< its share of a quota until it is sent
};

/// Any message with a small payload except the end of an answer.
EncodedMessage encode(const pb::StreamFramesResponse& response);

/// Shortened ways, pairs of meshes, limits and contacts in chunks, then the end of the answer with the last of them: of
/// shortened ways and of pairs one chunk each at most, since two never fit. Each message has at most `max_chunk_bytes`
/// of arrays. Completes the cost of `frame`; the messages keep it alive as long as they refer to it.
std::vector<EncodedMessage> encode_answer(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame,
                                          size_t max_chunk_bytes);

}  // namespace collided::server
