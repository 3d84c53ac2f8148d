// Reports on streams and their frames.
#include "server/frames/log.hpp"

#include <spdlog/fmt/fmt.h>

#include "server/frames/watched.hpp"
#include "server/ops/log_rate.hpp"

namespace collided::server {

void tell_answered(const Scene& scene, const AnsweredFrame& frame, const CallIds& ids) {
  scene.observer().answered(scene, frame);
  log_event(spdlog::level::debug, "frame answered",
            {{"scene", scene.id()},
             {"frame", frame.frame_id},
             {"milliseconds", frame.cost.total_milliseconds},
             {"request", ids.request_id},
             {"trace", ids.trace_id}});
  tell_watchers(scene, frame);
}

Failure tell_refused(const Scene& scene, uint64_t frame_id, const std::exception_ptr& error, const CallIds& ids) {
  scene.observer().refused(scene, frame_id, error);
  Failure failure = describe(error);
  if (admit_refusal("frame", code_name(failure.code)))
    log_event(spdlog::level::info, "frame refused",
              {{"scene", scene.id()},
               {"frame", frame_id},
               {"code", code_name(failure.code)},
               {"reason", failure.message},
               {"request", ids.request_id},
               {"trace", ids.trace_id}});
  return failure;
}

void tell_skipped(const Scene& scene, uint64_t frame_id, const CallIds& ids) {
  scene.observer().counted(scene, CounterId::kSkippedFrames, 1);
  log_event(spdlog::level::debug, "frame skipped",
            {{"scene", scene.id()}, {"frame", frame_id}, {"request", ids.request_id}, {"trace", ids.trace_id}});
}

void log_stream_opened(const StreamKind& kind, const Scene& scene, uint32_t window, const CallIds& ids) {
  log_event(spdlog::level::info, fmt::format("{} opened", kind.name),
            {{"scene", scene.id()},
             {"window", window},
             {"client", scene.identity().owner->name},
             {"request", ids.request_id},
             {"trace", ids.trace_id}});
}

void tell_stream_ended(const StreamKind& kind, const StreamEnd& end, const CallIds& ids, Metrics& metrics) {
  const std::string code = code_name(end.code);
  metrics.count_call(kind.method, code);
  if (end.code != grpc::StatusCode::OK && !admit_refusal(kind.name, code)) return;
  log_event(end.level, fmt::format("{} ends", kind.name),
            {{"scene", end.scene},
             {"code", code},
             {"reason", end.reason},
             {"request", ids.request_id},
             {"trace", ids.trace_id}});
}

}  // namespace collided::server
