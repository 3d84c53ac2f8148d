// The log lines of a frame stream.
#include "server/service/stream_log.hpp"

#include <spdlog/fmt/fmt.h>

#include "server/ops/log_rate.hpp"

namespace collided::server {

void log_stream_opened(std::string_view stream, std::string_view scene, uint32_t window, std::string_view client,
                       const CallIds& ids) {
  log_event(
      spdlog::level::info, fmt::format("{} opened", stream),
      {{"scene", scene}, {"window", window}, {"client", client}, {"request", ids.request_id}, {"trace", ids.trace_id}});
}

void log_stream_ends(spdlog::level::level_enum level, std::string_view stream, std::string_view scene,
                     grpc::StatusCode code, std::string_view reason, const CallIds& ids) {
  if (code != grpc::StatusCode::OK && !admit_refusal(stream, code_name(code))) return;
  log_event(level, fmt::format("{} ends", stream),
            {{"scene", scene},
             {"code", code_name(code)},
             {"reason", reason},
             {"request", ids.request_id},
             {"trace", ids.trace_id}});
}

void log_frame_answered(std::string_view scene, const AnsweredFrame& frame, const CallIds& ids) {
  log_event(spdlog::level::debug, "frame answered",
            {{"scene", scene},
             {"frame", frame.frame_id},
             {"milliseconds", frame.cost.total_milliseconds},
             {"request", ids.request_id},
             {"trace", ids.trace_id}});
}

void log_frame_refused(std::string_view scene, uint64_t frame_id, const Failure& failure, const CallIds& ids) {
  if (!admit_refusal("frame", code_name(failure.code))) return;
  log_event(spdlog::level::info, "frame refused",
            {{"scene", scene},
             {"frame", frame_id},
             {"code", code_name(failure.code)},
             {"reason", failure.message},
             {"request", ids.request_id},
             {"trace", ids.trace_id}});
}

void log_frame_skipped(std::string_view scene, uint64_t frame_id, const CallIds& ids) {
  log_event(spdlog::level::debug, "frame skipped",
            {{"scene", scene}, {"frame", frame_id}, {"request", ids.request_id}, {"trace", ids.trace_id}});
}

}  // namespace collided::server
