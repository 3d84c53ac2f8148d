#pragma once
// Edges of one frame that go through triangles with which they share no vertex. Sure by bounds in double precision: the
// ends lie strictly on both sides of the triangle's plane, and the edge passes its three sides alike. What is neither
// sure nor surely apart is left to exact arithmetic (exact/crossings.hpp), ties among it.

#include "gpu/base/twofold.hpp"
#include "gpu/narrow/triangle_pairs.hpp"
#include "gpu/search/excluded_pairs.hpp"

namespace collided {

/// An edge's ends seen from the corners of a triangle, scaled as in Differences.
struct EdgeFromTriangle {
  Vec3<double> d[2][3];
  double extent;

  /// On which side of the triangle's plane an end is, or on which side of one of its sides the edge passes: 0 if that is
  /// not certain.
  COLLIDED_HD int side_of_end(int end) const { return certain_sign(d[end][0], d[end][1], d[end][2], extent); }
  COLLIDED_HD int side_of_edge(int k) const { return certain_sign(d[0][k], d[0][(k + 1) % 3], d[1][k], extent); }

  /// Whether a plane is certain to part them. All axes that can are tried, those in a common plane among them.
  COLLIDED_HD bool are_apart() const {
    const Vec3<double> e = d[1][0] - d[0][0];
    Vec3<double> q[3];
    for (int k = 0; k < 3; ++k) q[k] = d[0][k] - d[0][(k + 1) % 3];
    const Vec3<double> n = cross(q[0], q[1]);
    if (separates(d, n) || separates(d, cross(n, e))) return true;
    for (int k = 0; k < 3; ++k)
      if (separates(d, cross(n, q[k])) || separates(d, cross(e, q[k]))) return true;
    return false;
  }
};

enum class Crossing { kNone, kSure, kDoubt };

COLLIDED_HD inline Crossing look_at_crossing(const EdgeFromTriangle& pair) {
  const int across = pair.side_of_end(0) * pair.side_of_end(1);
  if (across == 1) return Crossing::kNone;
  int left = 0, right = 0;
  for (int k = 0; k < 3; ++k) {
    const int side = pair.side_of_edge(k);
    left += side > 0, right += side < 0;
  }
  if (left > 0 && right > 0) return Crossing::kNone;
  if (across == -1 && left + right == 3) return Crossing::kSure;
  return pair.are_apart() ? Crossing::kNone : Crossing::kDoubt;
}

/// Weights of the triangle's second and third corner, where a sure crossing is: within 2^-48.
COLLIDED_HD inline void find_weights(const Vec3<double> (&edge)[2], const Vec3<double> (&triangle)[3], double scale,
                                     double (&weights)[2]) {
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

/// Tests the edges that each triangle of a pair owns with the other triangle.
template <class Real>
struct TestCrossings {
  const Vec3<Real>* positions;
  WorldTable<Triangle> corners, sides;
  Span<const uint8_t> owned;  ///< as in ElementaryTests
  VertexRings rings;
  Span<const uint64_t> pairs;
  ContactSink<Real> contacts;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.early_exit.is_over()) return;
    const uint32_t a = first_id(pairs[i]), b = second_id(pairs[i]);
    test_edges(a, b);
    test_edges(b, a);
  }

 private:
  COLLIDED_HD void test_edges(uint32_t element, uint32_t triangle) const {
    const Triangle t = corners[triangle];
    const uint32_t edges = owned[element] >> 3 & 7u;
    if (edges == 0 || is_loose(t)) return;
    const Triangle of_element = corners[element], ids = sides[element];
    const uint32_t corner[3] = {of_element.x, of_element.y, of_element.z}, edge[3] = {ids.x, ids.y, ids.z};
    for (int k = 0; k < 3; ++k) {
      const uint32_t u = corner[k], v = corner[(k + 1) % 3];
      if ((edges >> k & 1u) == 0 || has(t, u) || has(t, v)) continue;
      if (rings.is_needed() && (rings.connect(u, t) || rings.connect(v, t))) continue;
      test(pack_ids(edge[k], triangle), {u, v}, t);
    }
  }
  COLLIDED_HD void test(uint64_t key, const EdgePair& ends, const Triangle& t) const {
    const Vec3<double> edge[2] = {at(ends.from), at(ends.to)}, triangle[3] = {at(t.x), at(t.y), at(t.z)};
    EdgeFromTriangle pair;
    pair.extent = 0;
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 3; ++k) {
        pair.d[i][k] = edge[i] - triangle[k];
        pair.extent = max(pair.extent, largest_component(pair.d[i][k]));
      }
    if (pair.extent == 0) return leave(key);
    const double scale = unit_scale(pair.extent);
    for (auto& row : pair.d)
      for (Vec3<double>& d : row) d = scale * d;
    pair.extent *= scale;
    const Crossing seen = look_at_crossing(pair);
    if (seen == Crossing::kDoubt) leave(key);
    if (seen != Crossing::kSure) return;
    double weights[2];
    find_weights(edge, triangle, scale, weights);
    contacts.report(key, {0, Real(0), static_cast<Real>(weights[0]), static_cast<Real>(weights[1]), kFlagCertified});
  }
  COLLIDED_HD void leave(uint64_t key) const { contacts.report(key, {0, Real(0), Real(0), Real(0), kFlagNear}); }
  COLLIDED_HD Vec3<double> at(uint32_t vertex) const { return convert<double>(positions[vertex]); }
  COLLIDED_HD static bool has(const Triangle& t, uint32_t v) { return t.x == v || t.y == v || t.z == v; }
};

}  // namespace collided
