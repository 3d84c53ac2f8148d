#pragma once
// Triangles of one frame that intersect, as closed sets: certain by bounds in the working precision, or near.
// Apart: the normals, the products of an edge of each and, for coplanar triangles, the normals of the edges in the
// plane hold a separating axis whenever there is one. Certain to meet: an edge of one goes through the inside of the
// other.
// Triangles that share one corner always meet there. They are a contact if the side of one that is opposite to that
// corner meets the other. For triangles with area this is the same as a second common point: the part that they share
// is convex and begins at the corner, and where it ends, one of these sides does.

#include "gpu/narrow/crossings.hpp"

namespace collided {

/// Turns the triangles until a vertex that both have comes first in both. Returns false, and leaves them as they are,
/// if they have none in common.
COLLIDED_HD inline bool turn_to_common_corner(Vec3<uint32_t>& a, Vec3<uint32_t>& b) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a.x == b.x) return true;
      b = {b.y, b.z, b.x};
    }
    a = {a.y, a.z, a.x};
  }
  return false;
}

template <class Work>
COLLIDED_HD bool are_apart(const TriangleDifferences<Work>& pair) {
  Vec3<Work> p[3], q[3];
  for (int k = 0; k < 3; ++k) {
    p[k] = pair.d[(k + 1) % 3][0] - pair.d[k][0];
    q[k] = pair.d[0][k] - pair.d[0][(k + 1) % 3];
  }
  const Vec3<Work> n = cross(p[0], p[1]), m = cross(q[0], q[1]);
  if (separates(pair.d, n) || separates(pair.d, m)) return true;
  for (int i = 0; i < 3; ++i) {
    if (separates(pair.d, cross(n, p[i])) || separates(pair.d, cross(m, q[i]))) return true;
    for (int j = 0; j < 3; ++j)
      if (separates(pair.d, cross(p[i], q[j]))) return true;
  }
  return false;
}

/// Looks whether two triangles without a common vertex meet.
template <class Work>
COLLIDED_HD Crossing look_at(const TriangleDifferences<Work>& pair) {
  if (are_apart(pair)) return Crossing::kNone;
  const EdgesFromTriangle<Work, false> of_first(pair);
  const EdgesFromTriangle<Work, true> of_second(pair);
  for (int k = 0; k < 3; ++k)
    if (of_first.look(k) == Crossing::kSure || of_second.look(k) == Crossing::kSure) return Crossing::kSure;
  return Crossing::kDoubt;
}

/// Looks whether two triangles whose first corners are one vertex meet beyond it.
template <class Work>
COLLIDED_HD COLLIDED_CALLED Crossing look_beyond_corner(const TriangleDifferences<Work>& pair) {
  constexpr int kOpposite = 1;  // the side from the second corner to the third
  const Crossing first = EdgesFromTriangle<Work, false>(pair).look_closely(kOpposite);
  if (first == Crossing::kSure) return first;
  const Crossing second = EdgesFromTriangle<Work, true>(pair).look_closely(kOpposite);
  return second == Crossing::kNone ? first : second;
}

template <class Work, class Real>
struct TestTriangles {
  const Vec3<Real>* positions;
  WorldTable<Vec3<uint32_t>> triangles;
  Span<const uint64_t> pairs;  ///< first triangle in the upper half
  ContactSink<Real> contacts;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.early_exit.is_over()) return;
    const uint64_t key = pairs[i];
    Vec3<uint32_t> a = triangles[key >> 32], b = triangles[static_cast<uint32_t>(key)];
    const bool has_common_corner = turn_to_common_corner(a, b);
    TriangleDifferences<Work> pair;
    Crossing seen = Crossing::kSure;  // all in one place
    if (load_differences(a, b, positions, pair)) seen = has_common_corner ? look_beyond_corner(pair) : look_at(pair);
    if (seen == Crossing::kNone) return;
    contacts.report(key, {0, Real(0), Real(0), Real(0), seen == Crossing::kSure ? kFlagCertified : kFlagNear});
  }
};

}  // namespace collided
