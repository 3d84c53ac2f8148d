#pragma once
// Edges of one frame that go through triangles with which they share no vertex. Sure by bounds in double precision: the
// ends lie strictly on both sides of the triangle's plane, and the edge passes its three sides alike. What is neither
// sure nor surely apart is left to exact arithmetic (exact/crossings.hpp), ties among it.

#include "gpu/base/twofold.hpp"
#include "gpu/narrow/triangle_differences.hpp"

namespace collided {

/// use(i) for i = 0, 1, 2: written out, so that a GPU holds what is numbered by i in registers.
template <class Use>
COLLIDED_HD void for_each_corner(const Use& use) {
  use(0), use(1), use(2);
}

enum class Crossing { kNone, kSure, kDoubt };

/// An edge's ends seen from the corners of a triangle, scaled as in Differences.
template <class Work>
struct EdgeFromTriangle {
  Vec3<Work> d[2][3];
  Work extent;

  /// Whether a plane is certain to part them. All axes that can are tried, those in a common plane among them.
  COLLIDED_HD bool are_apart() const {
    const Vec3<Work> e = d[1][0] - d[0][0];
    Vec3<Work> q[3];
    for (int k = 0; k < 3; ++k) q[k] = d[0][k] - d[0][(k + 1) % 3];
    const Vec3<Work> n = cross(q[0], q[1]);
    if (separates(d, n) || separates(d, cross(n, e))) return true;
    for (int k = 0; k < 3; ++k)
      if (separates(d, cross(n, q[k])) || separates(d, cross(e, q[k]))) return true;
    return false;
  }

  /// What signs tell. `across`: -1 if the ends are on different sides of the triangle's plane, 1 if they are on the
  /// same, 0 if that is not certain.
  COLLIDED_HD Crossing look(int across) const {
    if (across == 1) return Crossing::kNone;
    int left = 0, right = 0;
    for_each_corner([&](int k) {
      const int side = certain_sign(d[0][k], d[0][(k + 1) % 3], d[1][k], extent);
      left += side > 0, right += side < 0;
    });
    if (left > 0 && right > 0) return Crossing::kNone;
    return across == -1 && left + right == 3 ? Crossing::kSure : Crossing::kDoubt;
  }
};

/// Which edges of one triangle go through another, of which it has these differences. `kSwapped`: the other way round.
template <class Work, bool kSwapped>
class EdgesFromTriangle {
 public:
  COLLIDED_HD explicit EdgesFromTriangle(const TriangleDifferences<Work>& pair) : pair_(pair) {
    for_each_corner([&](int i) { side_[i] = certain_sign(at(i, 0), at(i, 1), at(i, 2), pair.extent); });
  }

  /// From corner i to the next.
  COLLIDED_HD EdgeFromTriangle<Work> edge(int i) const {
    EdgeFromTriangle<Work> edge;
    edge.extent = pair_.extent;
    for_each_corner([&](int j) { edge.d[0][j] = at(i, j), edge.d[1][j] = at((i + 1) % 3, j); });
    return edge;
  }
  /// What signs tell of this edge.
  COLLIDED_HD Crossing look(int i) const { return edge(i).look(side_[i] * side_[(i + 1) % 3]); }
  /// What signs tell of this edge, and where they leave it in doubt, planes.
  COLLIDED_HD Crossing look_closely(int i) const {
    const Crossing seen = look(i);
    return seen == Crossing::kDoubt && edge(i).are_apart() ? Crossing::kNone : seen;
  }
  /// Those edges, one bit for each, that signs do not rule out.
  COLLIDED_HD uint32_t left_of(uint32_t edges) const {
    uint32_t left = 0;
    for_each_corner([&](int i) {
      if ((edges >> i & 1u) != 0 && look(i) != Crossing::kNone) left |= 1u << i;
    });
    return left;
  }

 private:
  COLLIDED_HD Vec3<Work> at(int i, int j) const { return kSwapped ? Work(-1) * pair_.d[j][i] : pair_.d[i][j]; }

  const TriangleDifferences<Work>& pair_;
  int side_[3];  ///< of the triangle's plane, that the corners are on; 0 if that is not certain
};

/// Finds the weights of the triangle's second and third corner where a sure crossing is, within 2^-48.
COLLIDED_HD inline void find_weights(const Vec3<double> (&edge)[2], const Vec3<double> (&triangle)[3],
                                     double (&weights)[2]) {
  double extent = 0;
  for (const Vec3<double>& corner : triangle)
    extent = max(extent, max(largest_component(edge[0] - corner), largest_component(edge[1] - corner)));
  const double scale = unit_scale(extent);
  Vec3<Twofold> from[3];
  double volume[3];
  for (int k = 0; k < 3; ++k) from[k] = scaled(exact_difference(edge[0], triangle[k]), scale);
  for (int k = 0; k < 3; ++k) {
    const Vec3<Twofold> to = scaled(exact_difference(edge[1], triangle[k]), scale);
    volume[k] = abs(triple(from[k], from[(k + 1) % 3], to).high);
  }
  const double all = volume[0] + volume[1] + volume[2];
  weights[0] = volume[2] / all;
  weights[1] = min(volume[0] / all, 1 - weights[0]);
}

}  // namespace collided
