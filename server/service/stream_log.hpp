#pragma once
// The log lines of a frame stream, whatever it travels on. Ids that are empty are left out.

#include <spdlog/common.h>

#include <string_view>

#include "server/ops/log.hpp"
#include "server/scenes/frame_run.hpp"
#include "server/service/status.hpp"

namespace collided::server {

/// `stream`: "stream" or "local stream"; `level`: of its end.
void log_stream_opened(std::string_view stream, std::string_view scene, uint32_t window, std::string_view client,
                       const CallIds& ids);
void log_stream_ends(spdlog::level::level_enum level, std::string_view stream, std::string_view scene,
                     grpc::StatusCode code, std::string_view reason, const CallIds& ids);
void log_frame_answered(std::string_view scene, const AnsweredFrame& frame, const CallIds& ids);
void log_frame_refused(std::string_view scene, uint64_t frame_id, const Failure& failure, const CallIds& ids);
void log_frame_skipped(std::string_view scene, uint64_t frame_id, const CallIds& ids);

}  // namespace collided::server
