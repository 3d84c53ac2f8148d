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

}  // namespace collided::client
