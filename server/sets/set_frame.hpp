#pragma once
// The frame of a set of worlds, from the protocol to the engine: its positions lie as one array of all worlds.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "collided/v1/batch.pb.h"
#include "gpu/detector.hpp"
#include "server/convert/frame.hpp"

namespace collided::server {

namespace pb = collided::v1;

struct SetFrameInput {
  FrameInput input;              ///< its updates refer to the message
  std::vector<uint32_t> worlds;  ///< in the frame, ascending
  std::vector<uint32_t> meshes;  ///< of each of these worlds, ascending
};

/// Throws InvalidInput, naming fields as those of "frame".
SetFrameInput parse_set_frame(const pb::SetFrame& frame, const SceneSpec& set);
/// The same for a frame of a stream, whose positions are as for parse_frame().
SetFrameInput parse_set_frame(const pb::Frame& frame, std::span<const PlacedPositions> placed, const SceneSpec& set);
/// Throws InvalidInput for what only frames of sets have.
void check_no_worlds(const pb::Frame& frame);

/// Bytes of all updates' positions.
uint64_t position_bytes_of(const FrameInput& input);
/// Moves the positions to `room`, which has as many bytes: each update's start and end, one update after the other, so
/// that they are brought to a device in one copy.
void move_to(std::span<std::byte> room, FrameInput& input);

}  // namespace collided::server
