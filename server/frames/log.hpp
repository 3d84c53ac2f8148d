#pragma once
// Reports on streams and their frames, on any transport: to the scene's observer, which counts them, to the log, and to
// the scene's watchers. Empty ids are left out.

#include <spdlog/common.h>

#include <exception>
#include <string_view>

#include "server/frames/frame.hpp"
#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"
#include "server/refusals/status.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

/// The frame's cost must be complete. On the scene's worker, after the answer has been handed over.
void tell_answered(const Scene& scene, const AnsweredFrame& frame, const CallIds& ids);
/// Returns what to tell the client.
Failure tell_refused(const Scene& scene, uint64_t frame_id, const std::exception_ptr& error, const CallIds& ids);
void tell_skipped(const Scene& scene, uint64_t frame_id, const CallIds& ids);

/// How the log and the metrics name the streams of a transport.
struct StreamKind {
  std::string_view name;    ///< "stream" or "local stream"
  std::string_view method;  ///< in the counted calls
};

void log_stream_opened(const StreamKind& kind, const Scene& scene, uint32_t window, const CallIds& ids);

struct StreamEnd {
  spdlog::level::level_enum level = spdlog::level::info;
  std::string_view scene;  ///< as requested by the client
  grpc::StatusCode code = grpc::StatusCode::OK;
  std::string_view reason;
};
/// Counts the stream as an ended call, and logs why it ended.
void tell_stream_ended(const StreamKind& kind, const StreamEnd& end, const CallIds& ids, Metrics& metrics);

}  // namespace collided::server
