// One frame from its message to its answer.
#include "server/service/service_frame.hpp"

#include <spdlog/spdlog.h>

#include "server/errors.hpp"

namespace collided::server {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); }

uint64_t total_bytes(const std::vector<MemoryPart>& memory) {
  uint64_t bytes = 0;
  for (const auto& part : memory) bytes += part.bytes;
  return bytes;
}

}  // namespace

FrameAnswer run_frame(Scene& scene, const FrameJob& job) {
  FrameCost cost;
  cost.queue_milliseconds = milliseconds(Clock::now() - job.arrival);
  cost.bytes_in = position_bytes(job.frame);
  FrameInput input = parse_frame(job.frame, scene.plan().engine);
  input.cancelled = job.cancelled;
  if (input.cancelled && input.cancelled()) throw Cancelled();
  const FrameResult result = scene.apply(job.frame.frame_id(), input);
  FrameAnswer answer;
  answer.contacts = make_chunks(result, scene.topology(), scene.plan().fields, kMaxChunkBytes);
  cost.bytes_out = array_bytes(answer.contacts);
  cost.device_bytes = total_bytes(scene.snapshot().memory);
  cost.total_milliseconds = milliseconds(Clock::now() - job.arrival);
  fill_done(result, cost, &answer.done);
  spdlog::debug("scene {} frame {}: {} contacts in {:.3f} ms", scene.id(), job.frame.frame_id(),
                answer.done.contact_count(), cost.total_milliseconds);
  return answer;
}

void check_answer(const FrameAnswer& answer, uint64_t frame_id) {
  const uint64_t bytes = answer.done.metrics().bytes_out();
  if (bytes > kMaxAnswerBytes)
    throw LimitExceeded("", fmt::format("frame {} was applied, but its {} contacts take {} bytes, and one answer holds "
                                        "at most {}; use StreamFrames, which sends them in chunks",
                                        frame_id, answer.done.contact_count(), bytes, kMaxAnswerBytes));
}

}  // namespace collided::server
