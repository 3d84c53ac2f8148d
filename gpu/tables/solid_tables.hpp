#pragma once
// What steps look up of a scene's solids, made once from its meshes.

#include "gpu/contacts/solid_meshes.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Returns tables of the spec's solids; empty ones where nothing is asked of solids, or there are none. The topology
/// outlives them.
SolidTables make_solid_tables(const SceneSpec& spec, const Topology& topology);

}  // namespace collided
