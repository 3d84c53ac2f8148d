#pragma once
// New positions of a mesh in the caller's memory.

#include <cstddef>
#include <cstdint>
#include <span>

namespace collided::client {

/// New positions of one mesh, borrowed: bytes of the wire (little-endian, packed x y z) in the scene's format.
struct FrameUpdate {
  uint32_t mesh = 0;                                ///< index in the scene's spec
  std::span<const std::byte> positions = {};        ///< t = 1: of all vertices, or one for each index
  std::span<const std::byte> start_positions = {};  ///< t = 0 (CCD), as many; empty: where the last frame left the mesh
  std::span<const std::byte> indices = {};  ///< uint32, strictly ascending: a sparse update; empty: the whole mesh
};

}  // namespace collided::client
