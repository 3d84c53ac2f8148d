#pragma once
// Closed meshes for tests of solids and of what crosses. Triangles face outward; boxes have 12 of them, and the
// diagonals of opposite faces are parallel.

#include <string>
#include <utility>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

using Triangles = std::vector<std::array<uint32_t, 3>>;

struct Shape {
  Positions positions;
  Triangles triangles;
};

/// Six times the volume of a tetrahedron, with the sign of its corners' order.
double volume6(const Positions& corners);

Shape box(const Vec3d& lo, const Vec3d& hi);
Shape unit_cube();
/// The corners may come in any order.
Shape tetrahedron(Positions corners);
/// One of the two that are inscribed in the unit cube.
Shape inscribed(bool is_other);
/// Around the z-axis.
Shape unit_ball(uint32_t bands, uint32_t sectors);
/// The same triangles, facing the other way.
Shape reversed(Shape shape);
/// One mesh of both.
Shape together(Shape first, const Shape& second);

/// Every mesh is tested with the others, and not with itself.
Case apart(const std::vector<Shape>& shapes);
Case alone(const Shape& shape);

struct Row {
  std::string name;  ///< its number in the table of contacts, and a letter where the row has several inputs
  Case input;
};
/// Rows 1 to 12.
std::vector<Row> pairs_of_solids();

/// 0, 1, ... for all vertices.
std::vector<uint32_t> in_order(const Case& c);
/// The case with its meshes, their vertices and triangles in another order, and what each vertex was.
std::pair<Case, std::vector<uint32_t>> renumbered(const Case& c, uint32_t seed);
/// Scales, then shifts.
Case moved(Case c, double scale, double by);

}  // namespace collided::test
