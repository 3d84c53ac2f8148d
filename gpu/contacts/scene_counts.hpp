#pragma once
// How much there is of what a scene is made of: all that a step has to know of its topology on the host.

#include <vector>

#include "gpu/types.hpp"

namespace collided {

struct SceneCounts {
  uint64_t vertices = 0, edges = 0;
  uint64_t triangles = 0, loose_edges = 0, loose_points = 0;  ///< `triangles`: of all elements
  std::vector<uint32_t> triangle_offset;                      ///< of each mesh; one more entry at the end

  SceneCounts() = default;
  SceneCounts(const Topology& topology)
      : vertices(topology.vertex_count),
        edges(topology.edges.size()),
        triangles(topology.triangles.size()),
        loose_edges(topology.loose_edges),
        loose_points(topology.loose_points),
        triangle_offset(topology.triangle_offset) {}

  bool has_loose_elements() const { return loose_edges + loose_points > 0; }
  /// How many first features the contacts of each kind may have.
  PerKind<uint64_t> first_features() const {
    return {.vertex_triangle = vertices, .edge_edge = edges, .triangle_triangle = triangles};
  }
};

}  // namespace collided
