// One DetectFrame call.
#include "server/service/detect_frame.hpp"

#include <spdlog/fmt/fmt.h>

#include "server/convert/chunks.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

// gRPC's default limit of a received message, less room for framing and metrics.
constexpr size_t kMaxAnswerBytes = (size_t{4} << 20) - (size_t{64} << 10);
constexpr size_t kMaxChunkBytes = size_t{2} << 20;

void check_size(const AnsweredFrame& frame, uint64_t bytes) {
  if (bytes <= kMaxAnswerBytes) return;
  throw LimitExceeded("frame", fmt::format("frame {} was applied, but its contacts take {} bytes, and one answer holds "
                                           "at most {}; use StreamFrames, which sends them in chunks",
                                           frame.frame_id, bytes, kMaxAnswerBytes));
}

void fill_answer(const Scene& scene, AnsweredFrame& frame, pb::DetectFrameResponse& response) {
  const auto begin = std::chrono::steady_clock::now();
  const auto chunks = cut_into_chunks(frame.result, scene.plan().fields, kMaxChunkBytes);
  for (const auto& chunk : chunks) frame.cost.bytes_out += chunk.count() * chunk.fields.contact_bytes();
  check_size(frame, frame.cost.bytes_out);
  for (const auto& chunk : chunks) fill_chunk(chunk, scene.topology(), response.add_contacts());
  frame.cost.encode_milliseconds = milliseconds_since(begin);
  frame.cost.total_milliseconds = milliseconds_since(frame.arrival);
  fill_done(frame.result, frame.cost, response.mutable_done());
}

}  // namespace

void detect_frame(UnaryCall<pb::DetectFrameRequest, pb::DetectFrameResponse>& call, Scene& scene, PendingFrame frame) {
  guard(call, [&] {
    try {
      if (scene.stream())
        throw FailedPrecondition(
            "scene_id",
            fmt::format("scene_id: scene {} has an open stream, which alone brings its frames", scene.id()));
      auto answered = run_frame(scene, frame, [&call] { return call.is_cancelled(); });
      fill_answer(scene, answered, call.response());
      scene.observer().answered(scene, answered);
    } catch (...) {
      scene.observer().refused(scene, frame.frame_id, std::current_exception());
      throw;
    }
    call.finish();
  });
}

}  // namespace collided::server
