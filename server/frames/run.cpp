// One frame from its positions to its contacts.
#include "server/frames/run.hpp"

#include <spdlog/fmt/fmt.h>

#include <new>
#include <string_view>

#include "server/errors.hpp"
#include "server/frames/watched.hpp"
#include "server/refusals/advice.hpp"

namespace collided::server {
namespace {

// While one shard of a scene yields, the others go on.
bool can_yield(const SceneSpec& spec) { return spec.device.backend == Backend::kCpu && !is_sharded(spec); }

// Called at each checkpoint of the engine: whether to abandon the frame. May yield its turn meanwhile.
bool should_stop(const ClientIdentity& owner, uint64_t frame_id, TurnsOfScene::Turn& turn, bool yields,
                 const std::function<bool()>& cancelled) {
  if (cancelled && cancelled()) return true;
  const double seconds = turn.seconds(), limit = owner.limits.max_frame_seconds;
  if (seconds > limit)
    throw LimitExceeded::quota(
        "client:" + owner.name,
        fmt::format("max_frame_seconds is {}, and frame {} has run for {:.3f} s", limit, frame_id, seconds));
  if (yields) turn.yield_turn(cancelled);
  return false;
}

bool has_found(const FrameProgress& progress) {
  return progress.pairs + progress.candidates + progress.contacts + progress.far_meshes.size() > 0;
}
// False for a frame that is refused for what it brings, before any work on it.
bool is_too_much(const LimitExceeded& refusal, const FrameProgress& progress) {
  return has_found(progress) || std::string_view(refusal.what()).starts_with("max_frame_seconds");
}
template <class Refusal>
Refusal advised(const Refusal& refusal, const Scene& scene, const FrameInput& frame, const FrameProgress& progress) {
  const auto plan = scene.plan();
  return with_advice(refusal, progress,
                     {plan->engine, frame, [&](uint32_t mesh) { return scene.record().mesh_name(mesh); }});
}

FrameResult apply_in_turn(Scene& scene, PendingFrame& frame, const std::function<bool()>& cancelled, FrameCost& cost) {
  auto turn = scene.engine().take_turn(cancelled);
  if (!frame.input.room.memory.empty()) frame.input.room.first_on_host = most_watched(scene.record().watchers());
  const ClientIdentity& owner = *scene.identity().owner;
  const bool yields = can_yield(scene.plan()->engine);
  frame.input.cancelled = [&] { return should_stop(owner, frame.frame_id, turn, yields, cancelled); };
  FrameProgress progress;
  frame.input.progress = &progress;
  FrameResult result;
  try {
    result = scene.engine().apply(frame.frame_id, frame.input, frame.basis);
  } catch (const LimitExceeded& e) {
    if (!is_too_much(e, progress)) throw;
    throw advised(e, scene, frame.input, progress);
  } catch (const ResourceExhausted& e) {
    if (!has_found(progress)) throw;
    throw advised(e, scene, frame.input, progress);
  } catch (const DeviceError& e) {
    scene.observer().device_failed(scene, e.what());
    throw;
  }
  cost.engine_milliseconds = turn.seconds() * 1000;
  cost.queue_milliseconds = milliseconds_since(frame.arrival) - frame.decode_milliseconds - cost.engine_milliseconds;
  return result;
}

}  // namespace

std::exception_ptr unanswered(uint64_t frame_id, bool is_trial, const std::exception_ptr& why) {
  const auto but = [&](const char* reason) {
    return fmt::format("frame {} was {}, but {}", frame_id, is_trial ? "computed" : "applied", reason);
  };
  try {
    std::rethrow_exception(why);
  } catch (const std::bad_alloc&) {
    return std::make_exception_ptr(ResourceExhausted(but("the daemon is out of memory for its answer")));
  } catch (const LimitExceeded& e) {
    if (e.subject().empty()) return why;  // of the frame's own size, and says so
    return std::make_exception_ptr(LimitExceeded::quota(e.subject(), but(e.what()), e.retry_after_seconds()));
  } catch (...) {
    return why;
  }
}

AnsweredFrame run_frame(Scene& scene, PendingFrame& frame, const std::function<bool()>& cancelled) {
  if (frame.refusal) std::rethrow_exception(frame.refusal);
  if (cancelled && cancelled()) throw Cancelled();
  AnsweredFrame answered{frame.frame_id, frame.arrival, {}, {}, frame.tells_worlds};
  answered.cost.decode_milliseconds = frame.decode_milliseconds;
  answered.cost.bytes_in = frame.bytes_in;
  answered.result = apply_in_turn(scene, frame, cancelled, answered.cost);
  answered.cost.device_bytes = scene.record().device_bytes();
  return answered;
}

}  // namespace collided::server
