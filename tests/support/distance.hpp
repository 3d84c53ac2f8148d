#pragma once
// Closest points of two features: simply the minimum over all cases.

#include "tests/support/case.hpp"

namespace collided::test {

struct Closest {
  double distance = 0;
  std::array<double, 2> weights{};  ///< of the triangle's 2nd and 3rd corner, or along each edge
};

Vec3d lerp(const Vec3d& a, const Vec3d& b, double t);
double length_between(const Vec3d& a, const Vec3d& b);

/// The point of a triangle with these weights of its 2nd and 3rd corner.
Vec3d point_of(const std::array<Vec3d, 3>& triangle, const std::array<double, 2>& weights);

Closest point_triangle(const Vec3d& p, const std::array<Vec3d, 3>& triangle);
Closest edge_edge(const std::array<Vec3d, 2>& e, const std::array<Vec3d, 2>& f);

}  // namespace collided::test
