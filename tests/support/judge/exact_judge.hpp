#pragma once
// The judge: decides contacts of single pairs of features in integer arithmetic, so that only the mathematics can be
// wrong. It shares no code with the engine. All functions may be called from many threads at once; all throw
// std::invalid_argument where a coordinate or the thickness is not finite, or a part of the thickness is negative.

#include <gmpxx.h>

#include <array>

#include "tests/support/case.hpp"

namespace collided::test {

enum class QueryKind { kVertexTriangle, kEdgeEdge };

/// A thickness: the sum of three numbers >= 0 in real arithmetic.
struct Thickness {
  std::array<double, 3> parts;

  Thickness(double alone) : parts{alone, 0, 0} {}  // NOLINT: a number is a thickness
  Thickness(double a, double b, double c) : parts{a, b, c} {}
  bool is_zero() const { return parts == std::array<double, 3>{}; }
};

/// Eight points: v a b c (or a0 a1 b0 b1) at t = 0, then the same four at t = 1; each moves in a straight line at
/// constant speed. Features may be degenerate.
struct Query {
  QueryKind kind = QueryKind::kVertexTriangle;
  std::array<Vec3d, 8> p{};
};

/// The first time of contact lies in the closed interval [lower, upper], which is no wider than 2^-60; where the time
/// is a fraction k / 2^m that was hit while searching (always so for 0 and 1), both are that.
struct ExactImpact {
  bool hit = false;
  mpq_class lower, upper;
};

/// Whether and when the features touch, t in [0, 1].
ExactImpact judge_ccd(const Query& query);

/// Whether and when their distance is first <= thickness, t in [0, 1].
ExactImpact judge_ccd(const Query& query, const Thickness& thickness);

/// Whether the distance of the features (the first four points of a query) is <= thickness.
bool judge_proximity(QueryKind kind, const std::array<Vec3d, 4>& p, const Thickness& thickness);

/// Whether two closed triangles share a point; triangles may be coplanar, or a segment, or a point.
bool judge_triangles(const std::array<Vec3d, 3>& a, const std::array<Vec3d, 3>& b);

/// The same of triangles whose first corners are one vertex: whether the closed side opposite to it of one meets the
/// other.
bool judge_neighbours(const std::array<Vec3d, 3>& a, const std::array<Vec3d, 3>& b);

}  // namespace collided::test
