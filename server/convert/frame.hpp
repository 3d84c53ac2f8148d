#pragma once
// Frames between the protocol and the engine.

#include <span>

#include "collided/v1/frame.pb.h"
#include "gpu/detector.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Arrays of one update that are not in its message.
struct PlacedPositions {
  std::span<const std::byte> start, end, indices;
};

/// The frame in the engine's terms. Its positions are in `placed` (one entry for each update, or none at all), or else
/// in `frame` itself; the result refers to both. Throws InvalidInput for what the scene cannot have.
FrameInput parse_frame(const pb::Frame& frame, std::span<const PlacedPositions> placed, const SceneSpec& scene);

/// Totals, stages and counts of a frame; not its arrays, nor what it cost outside the engine.
void fill_result(const FrameResult& result, pb::FrameDone* out);

}  // namespace collided::server
