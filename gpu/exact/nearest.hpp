#pragma once
// Compares distances from a point to triangles exactly. It runs on the host, as the functions of exact.hpp do.
// Triangles without area are ordinary input.

#include <array>
#include <span>

#include "gpu/base/vec3.hpp"

namespace collided {

/// Returns 1 if `first` is farther from p than `second`, -1 if it is nearer, 0 if both are equally far.
int compare_distances(const Vec3<double>& p, const std::array<Vec3<double>, 3>& first,
                      const std::array<Vec3<double>, 3>& second);

/// Returns the index of the first of the triangles that are nearest to p. There is at least one.
size_t nearest_of(const Vec3<double>& p, std::span<const std::array<Vec3<double>, 3>> triangles);

}  // namespace collided
