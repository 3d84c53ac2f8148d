#pragma once
// What helps with a frame that was refused for its time or its memory. No gRPC here.

#include <functional>
#include <string>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {

/// A scene of which a frame was too much.
struct BusyScene {
  Mode mode;
  std::function<std::string(uint32_t)> mesh_name;  ///< with its number
};

/// The refusal, with what the frame had found by then, what is smaller, and which option raises the limit.
LimitExceeded with_advice(const LimitExceeded& refusal, const FrameProgress& progress, const BusyScene& scene);
/// Where the device or the host has no more memory, whatever the limits say.
ResourceExhausted with_advice(const ResourceExhausted& refusal, const FrameProgress& progress, const BusyScene& scene);

}  // namespace collided::server
