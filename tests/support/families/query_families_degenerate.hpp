#pragma once
// Features with next to no volume or area, used by both suites.

#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {

/// Touching features of which the second (sometimes both edges of a pair) is thinned to a fraction `width`: a triangle
/// towards a line, an edge towards a point.
Query needle(QueryKind kind, Random& random, double width);

/// The triangle's corners are collinear throughout, or an edge is a point throughout; numbers are small integers.
Query zero_area(QueryKind kind, Random& random);

/// Two of the four points coincide at t = 0, and in half the cases throughout; numbers are small integers.
Query duplicate_vertices(QueryKind kind, Random& random);

/// All points stay in one plane, tilted against the axes, without any rounding.
Query tilted_coplanar(QueryKind kind, Random& random);

/// Exact contacts, near contacts and integers, all shrunk to the smallest numbers that the scalar type has.
Query denormal(QueryKind kind, Scalar scalar, Random& random);

}  // namespace collided::test
