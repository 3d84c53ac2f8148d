#pragma once
// All tables of a scene's features, made on the host within its memory quota.

#include "gpu/tables/topology.hpp"

namespace collided {

/// `making` has the tables' bytes afterwards, and more while they are made. Throws InvalidInput as make_features(),
/// ResourceExhausted and InvalidInput as make_rings(), and what the quota and the question throw.
FeatureTables make_tables(const SceneSpec& spec, MemoryHold& making, Asks& asks);

}  // namespace collided
