#pragma once
// Decides on which side of a plane through three points a fourth one is. Ties are broken by Simulation of Simplicity
// (Edelsbrunner, Muecke 1990). The templates take integers of fixed size on any backend, and of any size on the host.
//
// Coordinate c of vertex i moves by e^(2^(3 i + c)), for an e > 0 as small as need be. The volume is linear in each
// coordinate, so it becomes a polynomial in e: each set of coordinates adds the volume's derivative by all of them,
// times e to the sum of their powers of two. Different sets have different sums, as binary numbers. The sign is
// therefore that of the first derivative that is not 0, in the order of these numbers. It depends on the order of ids
// alone. For points p0 to p3 in that order, with N = (p2 - p1) x (p3 - p1), M = (p2 - p0) x (p3 - p0), Q = (p3 - p0) x
// (p1 - p0), D = p3 - p2, E = p3 - p1, and 1x for coordinate x of p1:
//
//   number          derivative by              is
//    1,  2,  4      0x     0y      0z          -N.x   -N.y   -N.z
//    8, 10, 12      1x     1x 0y   1x 0z        M.x   -D.z    D.y
//   16, 17, 20      1y     1y 0x   1y 0z        M.y    D.z   -D.x
//   32, 33, 34      1z     1z 0x   1z 0y        M.z   -D.y    D.x     (0 here, since D is)
//   64, 66, 68      2x     2x 0y   2x 0z        Q.x    E.z   -E.y
//   80, 84          2x 1y  2x 1y 0z             p0.z - p3.z,  1
//
// All are made of differences, so they fit where the volume does.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

/// Returns det(b - a, c - a, d - a). It is above 0 if (b - a) x (c - a) points to the side of d.
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

/// Sorts the indices of `ids`, all different, by these. Returns 1 for an even permutation and -1 for an odd one.
template <int n>
COLLIDED_HD int sort_by_ids(const uint32_t (&ids)[n], int (&order)[n]) {
  int parity = 1;
  for (int i = 0; i < n; ++i) order[i] = i;
  for (int last = n - 1; last > 0; --last)
    for (int i = 0; i < last; ++i)
      if (ids[order[i]] > ids[order[i + 1]]) {
        const int after = order[i];
        order[i] = order[i + 1], order[i + 1] = after, parity = -parity;
      }
  return parity;
}

/// Returns the sign of the volume of points a b c d, 1 or -1, with ties broken. `volume_sign` is its real sign; `ids`
/// are the points' ids, all different.
template <class Int>
COLLIDED_HD COLLIDED_CALLED int sign_with_ties(int volume_sign, const Vec3<Int>* const (&points)[4],
                                               const uint32_t (&ids)[4]) {
  if (volume_sign != 0) return volume_sign;
  int order[4];
  const int parity = sort_by_ids(ids, order);
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
