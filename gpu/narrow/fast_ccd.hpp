#pragma once
// CCD at level FAST, as in the paper (section 3.3; Provot 1997): the times at which the four vertices are coplanar
// are roots of a cubic; the first of them at which the features are in proximity is the time of impact. Both ends
// of the step are looked at too. Working precision, no guarantee: degenerate motions can be missed.

#include "gpu/narrow/cubic.hpp"
#include "gpu/narrow/proximity.hpp"

namespace collided {

/// Proximity at a root, in units of the query's extent: what rounding alone may leave between touching features.
COLLIDED_HD inline float proximity_tolerance(float) { return 1e-6f; }
COLLIDED_HD inline double proximity_tolerance(double) { return 1e-9; }

/// Whether a stencil is that of a vertex and a loose edge or point, whose cubic is 0 (narrow/fast_loose.hpp).
COLLIDED_HD inline bool is_always_coplanar(const Stencil& s) { return s.v[2] == s.v[3]; }

template <class Real, class Kind>
struct SolveCubicCcd {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness;
  Kind kind;
  Span<const uint64_t> candidates;
  ContactSink<Real> contacts;
  HalfThicknesses halves = {};

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.early_exit.is_over()) return;
    const Stencil stencil = kind.stencil(candidates[i]);
    if (is_always_coplanar(stencil)) return;
    const Query q(stencil, start, end);
    const Cubic<Real> f = cubic(q);
    const Real limit = static_cast<Real>(halves.of_pair(thickness, stencil.v[0], stencil.v[3]).nearly());
    if (limit == 0 && f.one_sided()) return;
    const Real reach = limit + proximity_tolerance(Real(0)) * q.extent();
    if (report(i, q, Real(0), reach)) return;
    Real roots[3];
    const int n = roots_in_unit(f, roots);
    for (int r = 0; r < n; ++r)
      if (report(i, q, roots[r], reach)) return;
    report(i, q, Real(1), reach);
  }

 private:
  struct Query {
    Vec3<Real> x[4], y[4];

    COLLIDED_HD Query(const Stencil& s, const Vec3<Real>* start, const Vec3<Real>* end) {
      const Vec3<Real> o = start[s.v[0]];
      for (int k = 0; k < 4; ++k) {
        x[k] = start[s.v[k]] - o;
        y[k] = end[s.v[k]] - o;
      }
    }
    COLLIDED_HD Real extent() const {
      Real m = 0;
      for (int k = 0; k < 4; ++k) m = max(m, max(largest_component(x[k]), largest_component(y[k])));
      return m;
    }
    COLLIDED_HD Vec3<Real> at(int k, Real t) const { return t == 1 ? y[k] : x[k] + t * (y[k] - x[k]); }
  };

  COLLIDED_HD Cubic<Real> cubic(const Query& q) const {
    Vec3<Real> u[3], v[3];
    spanning_vectors(kind, q.x, u);
    spanning_vectors(kind, q.y, v);
    return moving_triple(u, v);
  }

  COLLIDED_HD bool report(uint64_t i, const Query& q, Real t, Real reach) const {
    const Vec3<Real> p[4] = {q.at(0, t), q.at(1, t), q.at(2, t), q.at(3, t)};
    const Closest<Real> found = closest(kind, p);
    const Real distance = std::sqrt(found.squared);
    if (!(distance <= reach)) return false;
    const uint8_t flags = t == 0 ? uint8_t{kFlagInitial} : uint8_t{0};
    contacts.report(candidates[i], {static_cast<double>(t), distance, found.w0, found.w1, flags});
    return true;
  }
};

}  // namespace collided
