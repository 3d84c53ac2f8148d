#pragma once
// The engine's exact decisions in the judge's terms.

#include <cmath>

#include "gpu/exact/fixed/decide.hpp"
#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

using Corners = Vec3<double>[4];

/// Four points of the query: from 0 on at t = 0, from 4 on at t = 1.
inline void corners_of(const Query& query, size_t from, Corners& out) {
  for (size_t i = 0; i < 4; ++i) {
    const Vec3d& p = query.p[from + i];
    out[i] = {p[0], p[1], p[2]};
  }
}

inline ContactKind contact_kind_of(const Query& query) {
  return query.kind == QueryKind::kVertexTriangle ? ContactKind::kVertexTriangle : ContactKind::kEdgeEdge;
}

/// A time that is never late, and early by what exact.hpp allows: 2^-60 and the rounding to a double.
inline bool time_agrees(double toi, const ExactImpact& truth) {
  const mpq_class time(toi), slack(mpq_class(1) >> 59);
  return time <= truth.upper && mpq_class(std::nextafter(toi, 2)) + slack >= truth.lower;
}

}  // namespace collided::test
