#pragma once
// Families of boxes, made of triangles, that break grids and trees.

#include "tests/support/case.hpp"

namespace collided::test {

/// One case per family; deterministic.
std::vector<Case> adversarial_cases();

/// `count` separate triangles of edge length about `size` within a cube of side `side` around `centre`, moving by
/// `step`.
Case soup(uint32_t seed, uint32_t count, double side, double size, double step, const Vec3d& centre = {});

/// Everything in one spot: all pairs of triangles are candidates many times over.
Case crowd();

/// A few triangles, with exponents as far apart as F64 allows: exact decisions take long.
Case far_apart();

}  // namespace collided::test
