#pragma once
// Decides exactly what two bodies have in common. It runs on the host, as the functions of exact.hpp do.

#include <array>
#include <cstdint>
#include <span>

#include "gpu/base/vec3.hpp"

namespace collided {

/// A closed mesh: its triangles use each edge as often in one direction as in the other.
struct SolidMesh {
  std::span<const Vec3<double>> points;                ///< any finite coordinates, denormals included
  std::span<const uint32_t> ids;                       ///< of the points, scene-wide
  std::span<const std::array<uint32_t, 3>> triangles;  ///< indices of points, three different ones each
};

/// Returns the volume that a and b have in common: the integral of the product of their winding numbers. It is within
/// 2^-50 of its size unless that is below 2^-1022. No id of a is one of b. Touching faces, edges and corners are
/// ordinary input.
double overlap_volume(const SolidMesh& a, const SolidMesh& b);

/// Returns true if that volume is above 0 in real arithmetic.
bool have_common_volume(const SolidMesh& a, const SolidMesh& b);

/// Returns true if the triangles go through each other: each has points on both sides of the other's plane on the line
/// that their insides have in common. Triangles in one plane and triangles without area do not.
bool insides_cross(const Vec3<double> (&first)[3], const Vec3<double> (&second)[3]);

}  // namespace collided
