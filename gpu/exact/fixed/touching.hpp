#pragma once
// Whether features at rest have a point in common, by signs of determinants.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

/// The signs of a vector's component along another one, which is parallel to it and not 0.
template <int N>
COLLIDED_HD int sign_along(const Vec3<Integer<N>>& a, const Vec3<Integer<N>>& n) {
  if (const int s = n.x.sign()) return s * a.x.sign();
  if (const int s = n.y.sign()) return s * a.y.sign();
  return n.z.sign() * a.z.sign();
}

// In one plane all cross products are parallel to the normal n, and P x Q times n tells the side. Without a normal, by
// the sides alone: the point is on one if P and Q are parallel and do not lead to the same side.
//
// `at`: 0 or 1, the time.
template <ContactKind kind, int W>
COLLIDED_HD bool touch(const Differences<kind, W>& features, int at) {
  constexpr int kCount = Sides<kind>::kCount;
  const auto d = [&](int i) -> const Vec3<Integer<W>>& { return features.d[i].p[at]; };
  if (!wide_dot(d(0), wide_cross(d(1), d(2))).is_zero()) return false;
  Vec3<Integer<2 * W>> sides[kCount];
  for (int i = 0; i < kCount; ++i) sides[i] = wide_cross(d(Sides<kind>::at(i).p), d(Sides<kind>::at(i).q));
  const auto n = normal_of<kind>(sides);
  const bool has_normal = !is_zero(n);
  for (int i = 0; i < kCount; ++i) {
    if (has_normal) {
      if (sign_along(sides[i], n) < 0) return false;
    } else if (is_zero(sides[i])) {
      const Side side = Sides<kind>::at(i);
      if (wide_dot(d(side.p), d(side.q)).sign() <= 0) return true;
    }
  }
  return has_normal;
}

}  // namespace collided::exact::fixed
