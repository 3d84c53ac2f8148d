#pragma once
// How much there is of what a scene is made of: all that a step has to know of its topology on the host.

#include <string>
#include <vector>

#include "gpu/base/worlds.hpp"
#include "gpu/contacts/kinds.hpp"

namespace collided {

/// All worlds together.
struct SceneCounts {
  uint64_t vertices = 0, edges = 0;
  uint64_t triangles = 0, loose_edges = 0, loose_points = 0;  ///< `triangles`: of all elements
  std::vector<uint32_t> triangle_offset;                      ///< of each mesh of a world; one more entry at the end
  uint32_t worlds = 0;                                        ///< as in SceneSpec

  SceneCounts() = default;
  /// `topology`: of one world.
  SceneCounts(const Topology& topology, uint32_t worlds = 0)
      : vertices(topology.vertex_count),
        edges(topology.edges.size()),
        triangles(topology.triangles.size()),
        loose_edges(topology.loose_edges),
        loose_points(topology.loose_points),
        triangle_offset(topology.triangle_offset),
        worlds(worlds) {
    for (uint64_t* count : {&vertices, &edges, &triangles, &loose_edges, &loose_points}) *count *= max(worlds, 1u);
  }

  WorldShape world_shape() const {
    const uint32_t count = max(worlds, 1u);
    return {count, static_cast<uint32_t>(vertices / count), static_cast<uint32_t>(edges / count),
            static_cast<uint32_t>(triangles / count)};
  }
  bool has_loose_elements() const { return loose_edges + loose_points > 0; }
  /// How many first features the contacts of each kind may have in a step's lists.
  PerKind<uint64_t> first_features() const {
    return {.vertex_triangle = vertices,
            .edge_edge = edges,
            .triangle_triangle = triangles,
            .edge_triangle = edges,
            .vertex_solid = 0};  // they are in no list of the step's
  }
};

/// Of the kinds that are wanted, and of those of features. Throws InvalidInput where there are too many.
inline FeatureRanks ranks_of(const PerKind<bool>& kinds, const SceneCounts& counts) {
  FeatureRanks ranks = {};
  uint64_t count = 0;
  for_each_kind(
      [&](ContactKind kind, bool is_wanted, uint64_t features) {
        if (is_wanted || is_of_features(kind)) count += features;
        ranks.begin[index_of(kind) + 1] = static_cast<uint32_t>(count);
      },
      kinds, counts.first_features());
  if (count >= ~0u)
    throw InvalidInput("meshes", "meshes have " + std::to_string(count) +
                                     " vertices, edges and triangles, the limit is " + std::to_string(~0u - 1));
  return ranks;
}

}  // namespace collided
