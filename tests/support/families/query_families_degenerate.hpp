#pragma once
// Features without volume or area to speak of, which both suites ask about.

#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {

/// Touching features whose second one (both of an edge pair's, now and then) is thinned to `width` of what it was:
/// a triangle towards a line, an edge towards a point.
Query needle(QueryKind kind, Random& random, double width);

/// The triangle's corners are collinear all along, or an edge is a point all along; numbers are small integers.
Query zero_area(QueryKind kind, Random& random);

/// Two of the four points are one at t = 0, and half the time all along; numbers are small integers.
Query duplicate_vertices(QueryKind kind, Random& random);

/// All points stay in one plane, tilted against the axes, without any rounding.
Query tilted_coplanar(QueryKind kind, Random& random);

/// Exact contacts, near contacts and integers, all shrunk to the smallest numbers that the scalar type has.
Query denormal(QueryKind kind, Scalar scalar, Random& random);

}  // namespace collided::test
