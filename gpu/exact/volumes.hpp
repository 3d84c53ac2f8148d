#pragma once
// Decides exactly whether a closed mesh has a volume above 0. It runs on the host, as the functions of exact.hpp do.

#include <array>
#include <functional>
#include <span>

#include "gpu/base/vec3.hpp"

namespace collided {

/// Returns the sign of the volume that the triangles enclose. They use each edge as often in one direction as in the
/// other. `point` returns the position of a vertex; it may have any finite coordinates, denormals included. Takes two
/// passes in double precision, and integers of any size only if that leaves the sign in doubt.
int sign_of_volume(std::span<const std::array<uint32_t, 3>> triangles,
                   const std::function<Vec3<double>(uint32_t)>& point);

}  // namespace collided
