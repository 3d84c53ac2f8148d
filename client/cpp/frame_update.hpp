#pragma once
// New positions of a mesh in the caller's memory.

#include <cstddef>
#include <cstdint>
#include <span>

namespace collided::client {

/// New positions of one mesh, borrowed: packed little-endian x y z in the scene's format, as they go on the wire.
struct FrameUpdate {
  uint32_t mesh = 0;                                ///< index in the scene's spec
  std::span<const std::byte> positions = {};        ///< t = 1: one for each vertex, or for each index
  std::span<const std::byte> start_positions = {};  ///< t = 0 (CCD), as many; empty: where the last frame ended
  std::span<const std::byte> indices = {};  ///< uint32, strictly ascending: a sparse update; empty: the whole mesh
};

}  // namespace collided::client
