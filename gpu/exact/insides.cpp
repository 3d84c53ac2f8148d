#include <algorithm>
#include <optional>

#include "gpu/exact/fraction.hpp"
#include "gpu/exact/integers.hpp"
#include "gpu/exact/overlap.hpp"

namespace collided {
namespace {

using exact::Fraction;
using exact::Number;
using exact::fixed::is_zero;
using exact::fixed::wide_cross;
using exact::fixed::wide_dot;
using Vector = Vec3<Number>;

struct Plane {
  const Vector& origin;
  Vector normal;
};
Plane plane_of(const Vector* t) { return {t[0], wide_cross(t[1] - t[0], t[2] - t[0])}; }

/// The part of a line that is in a triangle, by positions along the line.
struct Interval {
  Fraction lower, upper;
};

/// Returns the part of the line in direction `along` in which the triangle and a plane meet. Returns nothing unless
/// corners are on both sides of the plane: then the line goes through the inside.
std::optional<Interval> part_in(const Vector* t, const Plane& plane, const Vector& along) {
  Number heights[3];
  int least = 1, greatest = -1;
  for (int i = 0; i < 3; ++i) {
    heights[i] = wide_dot(plane.normal, t[i] - plane.origin);
    least = std::min(least, heights[i].sign());
    greatest = std::max(greatest, heights[i].sign());
  }
  if (least >= 0 || greatest <= 0) return std::nullopt;
  std::optional<Interval> part;
  const auto see = [&](const Fraction& at) {
    if (!part || compare(at, part->lower) < 0) part = Interval{at, part ? part->upper : at};
    if (compare(at, part->upper) > 0) part->upper = at;
  };
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Number at_i = wide_dot(along, t[i]), at_j = wide_dot(along, t[j]);
    if (heights[i].is_zero()) see({at_i});
    if (heights[i].sign() * heights[j].sign() >= 0) continue;
    const bool is_rising = heights[i].is_negative();
    const Number dividend = at_i * heights[j] - at_j * heights[i], divisor = heights[j] - heights[i];
    see(is_rising ? Fraction{dividend, divisor} : Fraction{-dividend, -divisor});
  }
  return part;
}

}  // namespace

bool insides_cross(const Vec3<double> (&first)[3], const Vec3<double> (&second)[3]) {
  const std::vector<Vector> p =
      exact::integers(std::array{first[0], first[1], first[2], second[0], second[1], second[2]});
  const Plane a = plane_of(&p[0]), b = plane_of(&p[3]);
  const Vector along = wide_cross(a.normal, b.normal);
  if (is_zero(along)) return false;
  const auto in_a = part_in(&p[0], b, along);
  if (!in_a) return false;
  const auto in_b = part_in(&p[3], a, along);
  return in_b && compare(in_a->lower, in_b->upper) < 0 && compare(in_b->lower, in_a->upper) < 0;
}

}  // namespace collided
