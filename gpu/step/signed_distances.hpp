#pragma once
// Distances with a sign, of contacts between features of solids.

#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/step/pair_states.hpp"

namespace collided {

/// Gives contacts of both kinds of features their signed distances (PerField::signed_distance), whose columns have room
/// for them, and turns the normals of negative ones, so that distance and normal together lead from the second
/// feature's closest point to the first one's.
void sign_distances(CpuLoops& loops, const FoundInSolids& found, PerKind<ContactSet>& contacts);

}  // namespace collided
