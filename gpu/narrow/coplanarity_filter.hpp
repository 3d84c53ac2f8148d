#pragma once
// Which candidates can never touch because their four vertices are never coplanar, certified in float.
//
// f(t), the determinant of three vectors that move linearly from x to y, is a cubic with Bernstein coefficients
//   b0 = [x1 x2 x3], 3 b1 = [y1 x2 x3] + [x1 y2 x3] + [x1 x2 y3], 3 b2 = [x1 y2 y3] + [y1 x2 y3] + [y1 y2 x3],
//   b3 = [y1 y2 y3];
// if all are above 0, or all below, f is. Contact makes f 0 at some time, contact within `thickness` makes |f| at most
// thickness * |n|, where n = v1 x v2 and |n| <= max(|x1|, |y1|) max(|x2|, |y2|).
//
// Bound, u = 2^-24, D_a the largest component of axis a: every determinant is six products of three components, each
// within (3 inputs + 6 operations) u of the truth; b0 and b3 are off by less than 60u Dx Dy Dz, 3 b1 and 3 b2 by less
// than 180u Dx Dy Dz. 96u and 288u are compared with. What underflows, an input or a product, is off by 2^-150 and is
// multiplied by at most two components: with components below 2^8 all of it together stays below kTiny. Larger ones,
// which a scene near 1 does not have, are not decided.

#include "gpu/base/box.hpp"
#include "gpu/base/precision.hpp"
#include "gpu/contacts/contact.hpp"
#include "gpu/narrow/cubic.hpp"
#include "gpu/narrow/features.hpp"

namespace collided {

struct NeverCoplanar {
  float thickness;  ///< scaled, rounded up

  COLLIDED_HD bool operator()(const Vec3<float> (&x)[3], const Vec3<float> (&y)[3]) const {
    const Vec3<float> d{largest_of(&Vec3<float>::x, x, y), largest_of(&Vec3<float>::y, x, y),
                        largest_of(&Vec3<float>::z, x, y)};
    if (!(max(d.x, max(d.y, d.z)) < kLargest)) return false;
    const float volume = d.x * d.y * d.z;
    constexpr float u = Precision<float>::kUnit;
    float e = 96 * u * volume + Precision<float>::kTiny;
    if (thickness > 0) e = (e + thickness * (longer(x[0], y[0]) * longer(x[1], y[1]))) * (1 + 32 * u);
    const Cubic<float> f = moving_triple(x, y);
    return (f.b0 > e && f.b3 > e && f.b1x3 > 3 * e && f.b2x3 > 3 * e) ||
           (f.b0 < -e && f.b3 < -e && f.b1x3 < -3 * e && f.b2x3 < -3 * e);
  }

 private:
  static constexpr float kLargest = 256;

  COLLIDED_HD static float largest_of(float Vec3<float>::*axis, const Vec3<float> (&x)[3], const Vec3<float> (&y)[3]) {
    float m = 0;
    for (int k = 0; k < 3; ++k) m = max(m, max(magnitude(x[k].*axis), magnitude(y[k].*axis)));
    return m;
  }
  COLLIDED_HD static float longer(const Vec3<float>& a, const Vec3<float>& b) {
    constexpr float kUnderflow = 0x1p-70f;  // what the squares can lose
    return std::sqrt(max(dot(a, a), dot(b, b))) + kUnderflow;
  }
};

/// A power of two that brings the scene near 1, and the thickness times it, rounded up.
struct FilterScale {
  float scale, thickness;
};
/// `extent`: largest of the scene's bounds.
COLLIDED_HD inline FilterScale filter_scale(float extent, double thickness) {
  constexpr float kMax = 0x1p124f;
  const float scale = extent > 0 && extent < kMax ? unit_scale(extent) : 1.0f;
  return {scale, scaled_thickness<float>(thickness, static_cast<double>(scale))};
}

COLLIDED_HD inline FilterScale filter_within(const Box<float>& bounds, double thickness) {
  const Vec3<float> extent = bounds.hi - bounds.lo;
  return filter_scale(max(extent.x, max(extent.y, extent.z)), thickness);
}

/// Keeps the candidates that may be coplanar at some time.
template <class Real>
struct MaybeCoplanar {
  const FilterScale* filter;
  uint32_t of_world = 0;  ///< triangles of each world, which has a filter of its own; 0: there is one

  /// For candidates of the world that the triangle is in.
  COLLIDED_HD MaybeCoplanar at(uint32_t triangle) const {
    return of_world == 0 ? *this : MaybeCoplanar{filter + triangle / of_world};
  }

  template <class Kind>
  COLLIDED_HD bool operator()(const Kind& kind, const FeaturePoints<Real>& points) const {
    const FilterScale f = *filter;
    Vec3<float> x[3], y[3];
    load(kind, points.start, static_cast<Real>(f.scale), x);
    load(kind, points.end, static_cast<Real>(f.scale), y);
    return !NeverCoplanar{f.thickness}(x, y);
  }

 private:
  template <class Kind>
  COLLIDED_HD static void load(const Kind& kind, const Vec3<Real> (&p)[4], Real scale, Vec3<float> (&out)[3]) {
    Vec3<Real> v[3];
    spanning_vectors(kind, p, v);
    for (int k = 0; k < 3; ++k) out[k] = convert<float>(scale * v[k]);
  }
};

/// Keeps the candidates that the filter keeps, of those that a search has stored without it.
template <class Real, class Kind>
struct FilterCandidates {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  Kind kind;
  MaybeCoplanar<Real> keep;
  Span<const uint64_t> candidates;
  AppendList<uint64_t> kept;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (keep(kind, points_of(kind.stencil(candidates[i]), start, end))) kept.push(candidates[i]);
  }
};

}  // namespace collided
