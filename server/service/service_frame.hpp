#pragma once
// One frame from its message to its answer, for DetectFrame and StreamFrames alike. On the scene's worker thread.

#include <chrono>
#include <functional>
#include <vector>

#include "server/convert/convert.hpp"

namespace collided::server {

/// gRPC's default limit of a received message, less room for framing and metrics.
constexpr size_t kMaxAnswerBytes = (size_t{4} << 20) - (size_t{64} << 10);
constexpr size_t kMaxChunkBytes = size_t{2} << 20;

struct FrameJob {
  const pb::Frame& frame;
  std::chrono::steady_clock::time_point arrival;
  std::function<bool()> cancelled;
};

struct FrameAnswer {
  std::vector<pb::ContactChunk> contacts;
  pb::FrameDone done;
};

FrameAnswer run_frame(Scene& scene, const FrameJob& job);

/// Throws LimitExceeded if the answer does not fit one message.
void check_answer(const FrameAnswer& answer, uint64_t frame_id);

}  // namespace collided::server
