#include "tests/support/distance.hpp"

#include <algorithm>
#include <cmath>

namespace collided::test {
namespace {

Vec3d minus(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double along(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d d = minus(b, a);
  const double square = dot(d, d);
  return square > 0 ? std::clamp(dot(minus(p, a), d) / square, 0.0, 1.0) : 0.0;
}

void keep_closer(Closest& best, const Closest& other) {
  if (other.distance < best.distance) best = other;
}

// Solves the 2x2 system of a plane's Gram matrix; false if the feature is not two-dimensional.
bool solve(double aa, double ab, double bb, double pa, double pb, std::array<double, 2>& weights) {
  const double det = aa * bb - ab * ab;
  if (!(det > 1e-14 * aa * bb)) return false;
  weights = {(bb * pa - ab * pb) / det, (aa * pb - ab * pa) / det};
  return true;
}

}  // namespace

Vec3d lerp(const Vec3d& a, const Vec3d& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

double length_between(const Vec3d& a, const Vec3d& b) {
  const Vec3d d = minus(a, b);
  return std::sqrt(dot(d, d));
}

Vec3d point_of(const std::array<Vec3d, 3>& t, const std::array<double, 2>& w) {
  Vec3d p;
  for (int k = 0; k < 3; ++k) p[k] = t[0][k] + w[0] * (t[1][k] - t[0][k]) + w[1] * (t[2][k] - t[0][k]);
  return p;
}

Closest point_triangle(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  const double u = along(p, t[0], t[1]), v = along(p, t[0], t[2]), w = along(p, t[1], t[2]);
  Closest best{length_between(p, lerp(t[0], t[1], u)), {u, 0}};
  keep_closer(best, {length_between(p, lerp(t[0], t[2], v)), {0, v}});
  keep_closer(best, {length_between(p, lerp(t[1], t[2], w)), {1 - w, w}});
  const Vec3d a = minus(t[1], t[0]), b = minus(t[2], t[0]), q = minus(p, t[0]);
  std::array<double, 2> inner;
  if (solve(dot(a, a), dot(a, b), dot(b, b), dot(q, a), dot(q, b), inner) && inner[0] >= 0 && inner[1] >= 0 &&
      inner[0] + inner[1] <= 1)
    keep_closer(best, {length_between(p, point_of(t, inner)), inner});
  return best;
}

Closest edge_edge(const std::array<Vec3d, 2>& e, const std::array<Vec3d, 2>& f) {
  const double f0 = along(e[0], f[0], f[1]), f1 = along(e[1], f[0], f[1]);
  const double e0 = along(f[0], e[0], e[1]), e1 = along(f[1], e[0], e[1]);
  Closest best{length_between(e[0], lerp(f[0], f[1], f0)), {0, f0}};
  keep_closer(best, {length_between(e[1], lerp(f[0], f[1], f1)), {1, f1}});
  keep_closer(best, {length_between(f[0], lerp(e[0], e[1], e0)), {e0, 0}});
  keep_closer(best, {length_between(f[1], lerp(e[0], e[1], e1)), {e1, 1}});
  const Vec3d a = minus(e[1], e[0]), b = minus(f[0], f[1]), q = minus(f[0], e[0]);
  std::array<double, 2> inner;
  if (solve(dot(a, a), dot(a, b), dot(b, b), dot(q, a), dot(q, b), inner) && inner[0] >= 0 && inner[0] <= 1 &&
      inner[1] >= 0 && inner[1] <= 1)
    keep_closer(best, {length_between(lerp(e[0], e[1], inner[0]), lerp(f[0], f[1], inner[1])), inner});
  return best;
}

}  // namespace collided::test
