// One frame from its positions to its contacts.
#include "server/scenes/frame_run.hpp"

#include <utility>

#include "server/scenes/scene.hpp"

namespace collided::server {
namespace {

using Clock = std::chrono::steady_clock;

FrameResult apply_in_turn(Scene& scene, PendingFrame& frame, FrameCost& cost) {
  const auto turn = scene.take_turn(frame.input.cancelled);
  const auto begin = Clock::now();
  cost.queue_milliseconds = milliseconds_since(frame.arrival) - frame.decode_milliseconds;
  FrameResult result;
  try {
    result = scene.apply(frame.frame_id, frame.input);
  } catch (const DeviceError& e) {
    scene.observer().device_failed(scene, e.what());
    throw;
  }
  cost.engine_milliseconds = milliseconds_since(begin);
  return result;
}

}  // namespace

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

AnsweredFrame run_frame(Scene& scene, PendingFrame& frame, const std::function<bool()>& cancelled) {
  if (frame.refusal) std::rethrow_exception(frame.refusal);
  frame.input.cancelled = cancelled;
  if (cancelled && cancelled()) throw Cancelled();
  AnsweredFrame answered{frame.frame_id, frame.arrival, {}, {}};
  answered.cost.decode_milliseconds = frame.decode_milliseconds;
  answered.cost.bytes_in = frame.bytes_in;
  answered.result = apply_in_turn(scene, frame, answered.cost);
  answered.cost.device_bytes = scene.device_bytes();
  return answered;
}

}  // namespace collided::server
