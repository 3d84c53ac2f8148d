#pragma once
// How much there is of what a scene is made of: all that a step has to know of its topology on the host.

#include <vector>

#include "gpu/types.hpp"

namespace collided {

struct SceneCounts {
  uint64_t vertices = 0, edges = 0, triangles = 0;
  std::vector<uint32_t> triangle_offset;  ///< of each mesh; one more entry at the end

  SceneCounts() = default;
  SceneCounts(const Topology& topology)
      : vertices(topology.vertex_count),
        edges(topology.edges.size()),
        triangles(topology.triangles.size()),
        triangle_offset(topology.triangle_offset) {}

  /// How many first features the contacts of each kind may have.
  PerKind<uint64_t> first_features() const {
    return {.vertex_triangle = vertices, .edge_edge = edges, .triangle_triangle = triangles};
  }
};

}  // namespace collided
