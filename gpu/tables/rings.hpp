#pragma once
// The rings of vertices that few edges connect, made once from a scene's meshes (search/excluded_pairs.hpp).

#include <vector>

#include "gpu/exec/asks.hpp"
#include "gpu/types.hpp"

namespace collided {

/// The rings of all vertices, one after the other; both tables are empty if no mesh that may touch itself has rings.
struct RingTables {
  std::vector<uint32_t> begin;     ///< of each vertex of the scene; one more at the end
  std::vector<uint32_t> vertices;  ///< ascending for each vertex, without itself
};

/// Takes from `making`, which then has the tables' bytes more than before, what memory this needs. Throws
/// ResourceExhausted where the tables exceed the scene's budget, InvalidInput where they exceed the limits of their
/// numbers or steps, and what the quota and the question throw.
RingTables make_rings(const SceneSpec& spec, const Topology& topology, MemoryHold& making, Asks& asks);

/// Returns the rings of one edge of all vertices, whatever the spec has. Takes memory as make_rings().
RingTables make_neighbours(const Topology& topology, MemoryHold& making);

}  // namespace collided
