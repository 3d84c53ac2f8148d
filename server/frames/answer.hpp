#pragma once
// A frame's answer on any transport: its contacts in chunks, its cost, its last message.

#include <cstddef>
#include <functional>
#include <span>

#include "collided/v1/frame.pb.h"
#include "proto/constants.hpp"
#include "server/convert/chunks.hpp"
#include "server/frames/frame.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Bytes of arrays in one message of an answer over gRPC.
constexpr size_t kMaxChunkBytes = pb::kMaxAnswerBytes / 2;

/// Cuts the frame's contacts into chunks of at most `max_chunk_bytes` of arrays, and those that limit its way into
/// chunks of at most `max_limit_bytes`. Passes both to `encode`, and completes the frame's cost: `bytes_out` before
/// that call, the times after it.
void encode_contacts(const Scene& scene, AnsweredFrame& frame, size_t max_chunk_bytes, size_t max_limit_bytes,
                     const std::function<void(std::span<const Chunk> contacts, std::span<const Chunk> limits)>& encode);

/// The end of the answer, without contacts, limits, shortened ways and pairs of meshes. The frame's cost must be
/// complete.
pb::FrameDone done_message(const AnsweredFrame& frame);

}  // namespace collided::server
