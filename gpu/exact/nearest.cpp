#include "gpu/exact/nearest.hpp"

#include <utility>

#include "gpu/exact/fraction.hpp"
#include "gpu/exact/integers.hpp"
#include "gpu/exact/poll.hpp"

namespace collided {
namespace {

using Corners = std::array<Vec3<double>, 3>;
using exact::Fraction;
using exact::Number;
using exact::fixed::is_zero;
using exact::fixed::wide_cross;
using exact::fixed::wide_dot;
using Vector = Vec3<Number>;

Number square_of(const Vector& v) { return wide_dot(v, v); }

/// The square of the distance from 0 to the segment a b.
Fraction square_to_segment(const Vector& a, const Vector& b) {
  const Vector ab = b - a;
  if (wide_dot(a, ab).sign() >= 0) return {square_of(a)};
  if (wide_dot(b, ab).sign() <= 0) return {square_of(b)};
  return {square_of(wide_cross(a, b)), square_of(ab)};
}

/// The same to the triangle a b c: to its plane if 0 is above or below the triangle, else to its nearest side.
Fraction square_to_triangle(const Vector& a, const Vector& b, const Vector& c) {
  const Vector normal = wide_cross(b - a, c - a);
  const auto is_within = [&](const Vector& from, const Vector& to) {
    return wide_dot(wide_cross(from, to), normal).sign() >= 0;
  };
  if (!is_zero(normal) && is_within(a, b) && is_within(b, c) && is_within(c, a)) {
    const Number height = wide_dot(a, normal);
    return {height * height, square_of(normal)};
  }
  Fraction nearest = square_to_segment(a, b);
  for (const Fraction& other : {square_to_segment(b, c), square_to_segment(c, a)})
    if (compare(other, nearest) < 0) nearest = other;
  return nearest;
}

Fraction square_to_triangle(const exact::Unit& unit, const Vec3<double>& p, const Corners& t) {
  exact::PollScope::step();
  const Vector origin = unit(p);
  return square_to_triangle(unit(t[0]) - origin, unit(t[1]) - origin, unit(t[2]) - origin);
}

exact::Unit unit_of(const Vec3<double>& p, std::span<const Corners> triangles) {
  exact::Unit unit;
  unit.see(p);
  for (const Corners& t : triangles) unit.see(t);
  return unit;
}

}  // namespace

int compare_distances(const Vec3<double>& p, const Corners& first, const Corners& second) {
  const Corners both[] = {first, second};
  const exact::Unit unit = unit_of(p, both);
  return compare(square_to_triangle(unit, p, first), square_to_triangle(unit, p, second));
}

size_t nearest_of(const Vec3<double>& p, std::span<const Corners> triangles) {
  const exact::Unit unit = unit_of(p, triangles);
  size_t nearest = 0;
  Fraction least = square_to_triangle(unit, p, triangles[0]);
  for (size_t i = 1; i < triangles.size(); ++i) {
    Fraction square = square_to_triangle(unit, p, triangles[i]);
    if (compare(square, least) >= 0) continue;
    nearest = i;
    least = std::move(square);
  }
  return nearest;
}

}  // namespace collided
