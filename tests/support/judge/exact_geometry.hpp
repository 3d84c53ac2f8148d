#pragma once
// Shared by the judge's parts: exact positions over time, and the polynomials that locate a point or edge relative to a
// triangle or edge.

#include <span>

#include "tests/support/judge/exact_judge.hpp"
#include "tests/support/judge/exact_polynomial.hpp"

namespace collided::test {

/// Coordinates as integers: all of a query's numbers times one power of two.
struct ExactQuery {
  QueryKind kind;
  std::array<PolynomialVector, 4> x;  ///< positions of v a b c (or a0 a1 b0 b1), linear in time
  mpz_class thickness;
};

/// Throws std::invalid_argument, see exact_judge.hpp.
ExactQuery exact_query(const Query& query, const Thickness& thickness);

/// Four points as a query that stands still.
Query standing(QueryKind kind, const std::array<Vec3d, 4>& p);

/// Lines and planes: with normal n (of the triangle, or across both edges) and f = 0 where the four points are
/// coplanar, the distance of the plane or lines is |f| / |n|, and its foot is within the features where every one of
/// `inside` is >= 0. Some of these are > 0 then, unless n = 0.
struct Interior {
  Polynomial f;
  PolynomialVector normal;
  std::vector<Polynomial> inside;
};
PolynomialVector normal_of(const ExactQuery& q);
Polynomial coplanarity(const ExactQuery& q, const PolynomialVector& normal);
Interior interior_of(const ExactQuery& q);

/// A vertex and an edge of the query, by the number of their points.
struct VertexEdge {
  int vertex, from, to;
};
/// All whose contact is a contact of the query.
std::span<const VertexEdge> vertex_edges(QueryKind kind);

/// Whether the coordinates along one axis, which are linear in time, are more than `thickness` apart from t = 0 to 1.
bool apart_along_an_axis(const ExactQuery& q);
/// The same for thickness 0, from the original coordinates.
bool apart_along_an_axis(const Query& query);

}  // namespace collided::test
