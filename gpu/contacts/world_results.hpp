#pragma once
// The contacts of a set of worlds, world by world.

#include "gpu/base/worlds.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Where each world's contacts begin; their ids become those of the world.
WorldResults divide_by_world(const WorldShape& shape, PerKind<ContactSet>& contacts);

}  // namespace collided
