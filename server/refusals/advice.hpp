#pragma once
// What helps with a frame that was refused for its time or its memory. No gRPC here.

#include <functional>
#include <string>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {

/// Refers to a scene and to the frame that was too much for it; both outlive this.
struct BusyScene {
  const SceneSpec& spec;
  const FrameInput& frame;
  std::function<std::string(uint32_t)> mesh_name;  ///< with its number

  Mode mode() const {
    const Mode mode = frame.mode.value_or(spec.mode);
    return mode == Mode::kBoth ? Mode::kCcd : mode;
  }
  Accuracy accuracy() const { return frame.accuracy.value_or(spec.accuracy); }
  Report report() const { return frame.report.value_or(spec.report); }
};

/// The refusal, with what the frame had found by then, what of the scene's and the frame's settings could be smaller,
/// and which option raises the limit.
LimitExceeded with_advice(const LimitExceeded& refusal, const FrameProgress& progress, const BusyScene& scene);
/// Where the device or the host has no more memory, whatever the limits say.
ResourceExhausted with_advice(const ResourceExhausted& refusal, const FrameProgress& progress, const BusyScene& scene);

}  // namespace collided::server
