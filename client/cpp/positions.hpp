#pragma once
// Positions as they go on the wire.

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "collided/v1/frame.pb.h"

namespace collided::client {

using Positions = std::span<const std::array<double, 3>>;

/// Bytes of one vertex's position, 12 (F32) or 24 (F64). Throws Error (INVALID_ARGUMENT) for other formats.
uint64_t position_bytes(v1::PositionFormat format);

/// Packs as F32 (rounded to nearest) or F64. Throws Error (INVALID_ARGUMENT) for other formats.
std::string pack_positions(Positions positions, v1::PositionFormat format);

/// The update of one mesh; `start` (t = 0, for CCD) may be empty.
v1::MeshUpdate mesh_update(uint32_t mesh, v1::PositionFormat format, Positions positions, Positions start = {});

/// Moves coordinates the fraction of the way to `target` that the daemon moved them: FrameDone.advanced, or a frame's
/// from_last_fraction. Every bit is the daemon's; client/STEPPING.md has the formula. Throws Error (INVALID_ARGUMENT)
/// if there are not as many of one as of the other, or the fraction is not from 0 to 1.
void move_along(std::span<float> positions, std::span<const float> target, double fraction);
void move_along(std::span<double> positions, std::span<const double> target, double fraction);

}  // namespace collided::client
