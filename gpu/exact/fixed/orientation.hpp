#pragma once
// The orientation of four points, with ties broken by Simulation of Simplicity (Edelsbrunner, Muecke 1990). Templates
// on the integers: of fixed size (Integer) on any backend, of any size (Number) on the host.
//
// Coordinate c of vertex i moves by e^(2^(3 i + c)), for an e above 0 and smaller than any number that it is compared
// with. The volume V is then a polynomial in e: each set S of coordinates gives a term, the derivative of V by all of S
// times e to the sum of S's powers of two. (V is linear in each coordinate.) Different sets have different sums, and
// the set whose last coordinate comes first has the smaller one, so V's sign is that of its first derivative that is
// not 0, in the order of binary numbers. Only the order of ids counts, not their values. For vertices 0 1 2 3 in that
// order:
//   1, 2, 4          0x  0y  0z                  -N, N = (p2 - p1) x (p3 - p1)
//   8, 10, 12        1x  1x 0y  1x 0z            M.x, -D.z, D.y, M = (p2 - p0) x (p3 - p0), D = p3 - p2
//   16, 17, 20       1y  1y 0x  1y 0z            M.y, D.z (known to be 0), -D.x
//   32, 33, 34       1z  1z 0x  1z 0y            0, since p2 = p3 if all before are 0
//   64, 66, 68       2x  2x 0y  2x 0z            Q.x, E.z, -E.y, Q = (p3 - p0) x (p1 - p0), E = p3 - p1
//   80, 84           2x 1y  2x 1y 0z             p0.z - p3.z, 1
// The last one is never 0. All are made of differences, so that they fit where the volume fits.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

/// Returns det(b - a, c - a, d - a): above 0 if d is on the side of a b c that (b - a) x (c - a) points to.
template <class Int>
COLLIDED_HD COLLIDED_CALLED auto volume(const Vec3<Int>& a, const Vec3<Int>& b, const Vec3<Int>& c,
                                        const Vec3<Int>& d) {
  return wide_dot(b - a, wide_cross(c - a, d - a));
}

/// Returns the volume's sign, 1 or -1, with ties broken, for points of volume 0 in the order of their ids.
template <class Int>
COLLIDED_HD COLLIDED_CALLED int sign_of_tie(const Vec3<Int>& p0, const Vec3<Int>& p1, const Vec3<Int>& p2,
                                            const Vec3<Int>& p3) {
  const auto n = wide_cross(p2 - p1, p3 - p1);
  if (!n.x.is_zero()) return -n.x.sign();
  if (!n.y.is_zero()) return -n.y.sign();
  if (!n.z.is_zero()) return -n.z.sign();
  const auto m = wide_cross(p2 - p0, p3 - p0);
  const Vec3<Int> d = p3 - p2;
  if (!m.x.is_zero()) return m.x.sign();
  if (!d.z.is_zero()) return -d.z.sign();
  if (!d.y.is_zero()) return d.y.sign();
  if (!m.y.is_zero()) return m.y.sign();
  if (!d.x.is_zero()) return -d.x.sign();
  const auto q = wide_cross(p3 - p0, p1 - p0);
  const Vec3<Int> e = p3 - p1;
  if (!q.x.is_zero()) return q.x.sign();
  if (!e.z.is_zero()) return e.z.sign();
  if (!e.y.is_zero()) return -e.y.sign();
  const Int last = p0.z - p3.z;
  return last.is_zero() ? 1 : last.sign();
}

/// Returns the sign of the volume of points a b c d, 1 or -1, with ties broken. `volume_sign` is its real sign; `ids`
/// are the points' ids, all different.
template <class Int>
COLLIDED_HD COLLIDED_CALLED int sign_with_ties(int volume_sign, const Vec3<Int>* const (&points)[4],
                                               const uint32_t (&ids)[4]) {
  if (volume_sign != 0) return volume_sign;
  int order[4] = {0, 1, 2, 3}, parity = 1;
  for (int last = 3; last > 0; --last)
    for (int i = 0; i < last; ++i)
      if (ids[order[i]] > ids[order[i + 1]]) {
        const int after = order[i];
        order[i] = order[i + 1], order[i + 1] = after, parity = -parity;
      }
  return parity * sign_of_tie(*points[order[0]], *points[order[1]], *points[order[2]], *points[order[3]]);
}

template <int W, int n, class Use>
COLLIDED_HD void use_counted(const Unit& unit, const Vec3<double> (&points)[n], const Use& use) {
  Vec3<Integer<W>> counted[n];
  for (int i = 0; i < n; ++i) counted[i] = unit.count<W>(points[i]);
  use(static_cast<const Vec3<Integer<W>>*>(counted));
}
/// Calls use(p) with the points as integers of W limbs, `const Vec3<Integer<W>>* p`. Returns false if one or two limbs
/// are not enough for them.
template <int n, class Use>
COLLIDED_HD bool with_fixed_integers(const Vec3<double> (&points)[n], const Use& use) {
  Unit unit;
  unit.see(points);
  if (unit.fits<1>())
    use_counted<1>(unit, points, use);
  else if (unit.fits<2>())
    use_counted<2>(unit, points, use);
  else
    return false;
  return true;
}

}  // namespace collided::exact::fixed
