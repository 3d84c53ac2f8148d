#pragma once
// The elements around each vertex, made once from a scene's meshes (base/fans.hpp).

#include <vector>

#include "gpu/exec/asks.hpp"
#include "gpu/types.hpp"

namespace collided {

/// The fans of all vertices, one after the other; scenes that tell no features have none.
struct FanTables {
  std::vector<uint32_t> begin;     ///< of each vertex of the scene; one more at the end
  std::vector<uint32_t> elements;  ///< ascending for each vertex; loose points are in none
};

/// Takes from `making`, which then has the tables' bytes more than before, what memory this needs. Throws what the
/// quota and the question throw.
FanTables make_fans(const Topology& topology, MemoryHold& making, Asks& asks);

}  // namespace collided
