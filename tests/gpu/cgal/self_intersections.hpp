#pragma once
// Triangles of one mesh that intersect, found by CGAL (Polygon_mesh_processing), which shares no code with the engine.

#include "tests/support/brute_force.hpp"

namespace collided::test {

/// False if the tests were built without CGAL's headers.
bool has_cgal();

struct SelfIntersections {
  std::vector<PairKey> pairs;     ///< of triangles with area; ascending
  std::vector<uint32_t> no_area;  ///< triangles that CGAL leaves out of all pairs
};

/// Neighbours by one corner are a pair if the side of one that is opposite to it meets the other, and neighbours by a
/// side if both lie on each other in one plane. Throws std::runtime_error where a triangle does not fit onto the others
/// as on a surface with an inside and an outside.
SelfIntersections self_intersections(const Positions& positions, const std::vector<std::array<uint32_t, 3>>& triangles);

}  // namespace collided::test
