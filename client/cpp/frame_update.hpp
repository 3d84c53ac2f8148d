#pragma once
// New positions or a new pose of a mesh, in the caller's memory.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace collided::client {

/// p -> R p + t: the rows of [R | t], with R a rotation.
using RigidMatrix = std::array<double, 12>;

/// New positions of one mesh, or the pose of a rigid one, borrowed. Positions are packed little-endian x y z in the
/// scene's format, as they go on the wire.
struct FrameUpdate {
  uint32_t mesh = 0;                                ///< index in the scene's spec
  std::span<const std::byte> positions = {};        ///< t = 1: one for each vertex, or for each index
  std::span<const std::byte> start_positions = {};  ///< t = 0 (CCD), as many; empty: where the last frame ended
  std::span<const std::byte> indices = {};       ///< uint32, strictly ascending: a sparse update; empty: the whole mesh
  const RigidMatrix* transform = nullptr;        ///< t = 1: moves a rigid mesh's first positions, instead of new ones
  const RigidMatrix* start_transform = nullptr;  ///< t = 0 (CCD), with `transform`; null: where the last frame ended
};

}  // namespace collided::client
