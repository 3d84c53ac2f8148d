#pragma once
// Queries of four moving points, and what may be done to them without rounding.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "gpu/exact/exact.hpp"

namespace collided::test {

using Point = Vec3<double>;
using Impact = ExactImpact (*)(const Point (&)[4], const Point (&)[4], double);
using Proximity = bool (*)(const Point (&)[4], double);

struct Query {
  Point start[4], end[4];
  double thickness = 0;
};

template <ContactKind kind>
ExactImpact ccd(const Point (&start)[4], const Point (&end)[4], double thickness) {
  return exact_ccd(kind, start, end, thickness);
}
template <ContactKind kind>
bool proximity(const Point (&p)[4], double thickness) {
  return exact_proximity(kind, p, thickness);
}

inline ExactImpact impact(Impact decide, const Query& q) { return decide(q.start, q.end, q.thickness); }
inline ExactImpact vertex_triangle(const Query& q) { return impact(ccd<ContactKind::kVertexTriangle>, q); }
inline ExactImpact edge_edge(const Query& q) { return impact(ccd<ContactKind::kEdgeEdge>, q); }

/// `change` maps each point; is_end tells start from end.
template <class Change>
Query changed(Query q, Change change) {
  for (Point& p : q.start) p = change(p, false);
  for (Point& p : q.end) p = change(p, true);
  return q;
}

inline Query scaled(const Query& q, int exponent) {
  Query s = changed(q, [&](const Point& p, bool) {
    return Point{std::ldexp(p.x, exponent), std::ldexp(p.y, exponent), std::ldexp(p.z, exponent)};
  });
  s.thickness = std::ldexp(q.thickness, exponent);
  return s;
}

inline Query moved(const Query& q, const Point& start_by, const Point& end_by) {
  return changed(q, [&](const Point& p, bool is_end) { return p + (is_end ? end_by : start_by); });
}

/// The points in the order given.
inline Query permuted(const Query& q, const int (&order)[4]) {
  Query p = q;
  for (int i = 0; i < 4; ++i) {
    p.start[i] = q.start[order[i]];
    p.end[i] = q.end[order[i]];
  }
  return p;
}

inline Query reversed(Query q) {
  for (int i = 0; i < 4; ++i) std::swap(q.start[i], q.end[i]);
  return q;
}

/// The motion between two times, exact for small integers and dyadic times.
inline Query part(const Query& q, double from, double to) {
  Query p = q;
  for (int i = 0; i < 4; ++i) {
    const Point way = q.end[i] - q.start[i];
    p.start[i] = q.start[i] + from * way;
    p.end[i] = q.start[i] + to * way;
  }
  return p;
}

/// `root_is_not_before(t)` tells whether t <= the true time; toi is the last double of which it does.
template <class NotBefore>
void expect_last_double(double toi, NotBefore root_is_not_before) {
  EXPECT_TRUE(root_is_not_before(toi)) << toi;
  EXPECT_FALSE(root_is_not_before(std::nextafter(toi, 2.0))) << toi;
}

constexpr Point kOrigin{0, 0, 0};
constexpr double kTiniest = 0x1p-1074;

/// The triangle (0,0,0) (4,0,0) (0,4,0) at rest and a vertex that moves.
inline Query vertex_at_corner_triangle(const Point& from, const Point& to, double thickness = 0) {
  const Point b{4, 0, 0}, c{0, 4, 0};
  return {{from, kOrigin, b, c}, {to, kOrigin, b, c}, thickness};
}

}  // namespace collided::test
