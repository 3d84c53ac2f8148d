#pragma once
// Rays that go up from vertices, in the direction of z. The winding number of a solid around a vertex is the number of
// triangles that its ray leaves through, less those that it enters through (exact/fixed/ray_triangle.hpp). Signs are
// those of bounds in double precision; what they leave open is decided exactly.
//
// With a, b, c relative to the vertex, the ray's line passes the triangle if the areas b x c, c x a, a x b, seen from
// above, have one sign. It does so above the vertex if a.z (b x c) + b.z (c x a) + c.z (a x b) has the same sign. With
// u = 2^-53 a difference is within u of itself, so that an area is within 4u, and a product with a height within 6u, of
// the magnitudes of its terms, and the sum of three within 8u.

#include "gpu/base/box.hpp"

namespace collided {

/// Says what a ray does to a triangle.
enum class RaySign { kPasses, kLeaves, kEnters, kDoubt };

/// Holds an area seen from above, and the magnitudes of its terms.
struct AreaFromAbove {
  double value, magnitudes;

  COLLIDED_HD AreaFromAbove(const Vec3<double>& a, const Vec3<double>& b) {
    const double p = a.x * b.y, q = a.y * b.x;
    value = p - q;
    magnitudes = magnitude(p) + magnitude(q);
  }
  /// Returns 1 or -1, or 0 if that is not certain.
  COLLIDED_HD int sign() const {
    const double error = 0x1p-50 * magnitudes + kUnderflow;
    return value > error ? 1 : value < -error ? -1 : 0;
  }
  static constexpr double kUnderflow = 0x1p-1000;  ///< far more than terms lose that are too small
};

/// Returns what is certain of the ray from `from` and the triangle.
COLLIDED_HD inline RaySign look_along_ray(const Vec3<double>& from, const Vec3<double> (&triangle)[3]) {
  const Vec3<double> a = triangle[0] - from, b = triangle[1] - from, c = triangle[2] - from;
  if (a.z < 0 && b.z < 0 && c.z < 0) return RaySign::kPasses;
  const AreaFromAbove areas[3] = {{b, c}, {c, a}, {a, b}};
  int left = 0, right = 0;
  for (const AreaFromAbove& area : areas) {
    const int sign = area.sign();
    left += sign > 0, right += sign < 0;
  }
  if (left > 0 && right > 0) return RaySign::kPasses;
  if (left + right < 3) return RaySign::kDoubt;
  const double height = a.z * areas[0].value + b.z * areas[1].value + c.z * areas[2].value;
  const double magnitudes = magnitude(a.z) * areas[0].magnitudes + magnitude(b.z) * areas[1].magnitudes +
                            magnitude(c.z) * areas[2].magnitudes;
  const double error = 0x1p-49 * magnitudes + AreaFromAbove::kUnderflow;
  if (!(magnitude(height) > error)) return RaySign::kDoubt;
  if ((height > 0) != (left > 0)) return RaySign::kPasses;
  return left > 0 ? RaySign::kLeaves : RaySign::kEnters;
}

/// Returns whether the ray may meet what is in the box, or may begin on it.
COLLIDED_HD inline bool may_meet(const Vec3<double>& from, const Box<float>& box) {
  return double{box.lo.x} <= from.x && from.x <= double{box.hi.x} && double{box.lo.y} <= from.y &&
         from.y <= double{box.hi.y} && from.z <= double{box.hi.z};
}

}  // namespace collided
