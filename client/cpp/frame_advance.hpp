#pragma once
// Tells how far a frame with `advance` went.

#include <cstdint>
#include <vector>

#include "collided/v1/frame.pb.h"

namespace collided::client {

/// Holds how far the scene, each mesh or each vertex went. Without `advance` all went all of their way.
struct FrameAdvance {
  v1::AdvanceMode mode = v1::ADVANCE_MODE_ALL_OR_ONE;
  double advanced = 1;            ///< FrameDone.advanced: at ALL_OR_ONE the fraction of everything
  std::vector<uint32_t> ids;      ///< ascending: meshes, or scene-wide vertices, that did not go all of their way
  std::vector<double> fractions;  ///< of each of them, in [0, 1)

  /// Returns how far a mesh went that goes as a whole, in [0, 1]. Its vertices are `vertex_count` from the scene-wide
  /// `first_vertex` on.
  double of_body(uint32_t mesh, uint32_t first_vertex, uint32_t vertex_count) const;
  /// Returns how far a vertex went. `vertex`: scene-wide, of `mesh`.
  double of_vertex(uint32_t mesh, uint32_t vertex) const { return of_body(mesh, vertex, 1); }
};

/// Appends one message's shortened ways. Throws Error (DATA_LOSS) if it has none, or the lengths of its arrays do not
/// match. Throws the same for an id that does not ascend or is not below `id_count`, and a fraction outside [0, 1).
void append(FrameAdvance& advance, const v1::ShortenedWays& ways, uint64_t id_count);

}  // namespace collided::client
