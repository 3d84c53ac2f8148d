#pragma once
// Triangles of one frame that intersect, as closed sets: certain by bounds in the working precision, or near.
// Apart: the normals, the products of an edge of each and, for coplanar triangles, the normals of the edges in the
// plane hold a separating axis whenever there is one. Certain to meet: an edge of one goes through the inside of the
// other, that is, its ends lie on both sides of the plane and it passes all three edges on the same side.

#include "gpu/narrow/certificate.hpp"

namespace collided {

/// Differences a_i - b_j of the vertices of two triangles, scaled as in Differences.
template <class Work>
struct TriangleDifferences {
  Vec3<Work> d[3][3];
  Work extent;
};

/// False if all six vertices coincide.
template <class Work, class Real>
COLLIDED_HD bool load_differences(const Vec3<uint32_t>& a, const Vec3<uint32_t>& b, const Vec3<Real>* positions,
                                  TriangleDifferences<Work>& out) {
  using Wide = Wider<Work, Real>;
  const uint32_t first[3] = {a.x, a.y, a.z}, second[3] = {b.x, b.y, b.z};
  Vec3<Wide> d[3][3];
  Wide extent = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      d[i][j] = convert<Wide>(positions[first[i]]) - convert<Wide>(positions[second[j]]);
      extent = max(extent, largest_component(d[i][j]));
    }
  if (extent == 0) return false;
  const Wide scale = unit_scale(extent);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out.d[i][j] = convert<Work>(scale * d[i][j]);
  out.extent = static_cast<Work>(scale * extent);
  return true;
}

/// Whether a plane across the axis is certain to part n points from the corners of a triangle, from which they are at
/// d.
template <class Work, int n>
COLLIDED_HD bool separates(const Vec3<Work> (&d)[n][3], const Vec3<Work>& axis) {
  const Direction<Work> direction = direction_of(axis);
  if (direction.length == 0) return false;
  bool above = true, below = true;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 3; ++j) {
      above = above && lower_bound_along(direction.n, d[i][j], Work(0)) > 0;
      below = below && lower_bound_along(Work(-1) * direction.n, d[i][j], Work(0)) > 0;
    }
  return above || below;
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

/// Whether the edge of the first triangle from corner i to corner k goes through the inside of the second, for
/// certain; with `swapped` the triangles change places.
template <class Work>
COLLIDED_HD bool pierces(const TriangleDifferences<Work>& pair, int i, int k, bool swapped) {
  Vec3<Work> from[3], to[3];
  for (int j = 0; j < 3; ++j) {
    from[j] = swapped ? Work(-1) * pair.d[j][i] : pair.d[i][j];
    to[j] = swapped ? Work(-1) * pair.d[j][k] : pair.d[k][j];
  }
  const Work m = pair.extent;
  if (certain_sign(from[0], from[1], from[2], m) * certain_sign(to[0], to[1], to[2], m) != -1) return false;
  const int side = certain_sign(from[0], from[1], to[0], m);
  return side != 0 && certain_sign(from[1], from[2], to[1], m) == side &&
         certain_sign(from[2], from[0], to[2], m) == side;
}

template <class Work>
COLLIDED_HD bool certainly_meet(const TriangleDifferences<Work>& pair) {
  for (int i = 0; i < 3; ++i)
    if (pierces(pair, i, (i + 1) % 3, false) || pierces(pair, i, (i + 1) % 3, true)) return true;
  return false;
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
    const Vec3<uint32_t> a = triangles[key >> 32], b = triangles[static_cast<uint32_t>(key)];
    TriangleDifferences<Work> pair;
    uint8_t flags = kFlagCertified;
    if (load_differences(a, b, positions, pair)) {
      if (are_apart(pair)) return;
      if (!certainly_meet(pair)) flags = kFlagNear;
    }
    contacts.report(key, {0, Real(0), Real(0), Real(0), flags});
  }
};

}  // namespace collided
