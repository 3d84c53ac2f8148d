#pragma once
// Families of boxes, made of triangles, that break grids and trees.

#include "tests/support/case.hpp"

namespace collided::test {

/// One case per family; deterministic.
std::vector<Case> adversarial_cases();

/// `count` separate triangles of edge length about `size` within a cube of side `side` around `centre`, moving by
/// `step`.
Case soup(uint32_t seed, uint32_t count, double side, double size, double step, const Vec3d& centre = {});

/// A soup of three meshes: triangles with loose edges and points, some of them parts of others or there twice; hairs of
/// two edges; particles. `count` elements or more in each.
Case loose_soup(uint32_t seed, uint32_t count, double side, double size, double step);

/// Of each mesh every third triangle becomes two loose edges and every third one three loose points, while the vertices
/// stay as they are.
Case loosened(Case c);

/// Every coordinate rounded to an integer: features touch, are coplanar, coincide and have no extent, and no number is
/// rounded.
Case on_integers(Case c);

/// Everything in one spot: all pairs of triangles are candidates many times over.
Case crowd();

/// A few triangles, with exponents as far apart as F64 allows: exact decisions take long.
Case far_apart(uint32_t triangles = 10);

}  // namespace collided::test
