#include "gpu/exact/volumes.hpp"

#include <algorithm>
#include <cmath>

#include "gpu/exact/integers.hpp"
#include "gpu/exact/poll.hpp"

namespace collided {
namespace {

using Triangles = std::span<const std::array<uint32_t, 3>>;
using PointOf = std::function<Vec3<double>(uint32_t)>;
using exact::Number;
using exact::fixed::wide_cross;
using exact::fixed::wide_dot;

/// Returns 0 in doubt. All is relative to a vertex, times a power of two, so that coordinates are below 1.
///
/// A triangle's determinant is a sum of six products of three differences. Each of them takes at most eight roundings:
/// three of the differences, two of the products, three of the sums. The sum of n determinants takes n more. So its
/// error is at most ((1 + u)^(n + 8) - 1) S, u = 2^-53, where S is the sum of the products' magnitudes. `magnitudes` is
/// S but for the same relative error; while n u is below 2^-20, twice (n + 8) u covers both. Numbers below 2^-1022 add
/// an error of 2^-1075 for each of the twenty operations on a triangle at most, times factors below 2.
int rough_sign(Triangles triangles, const PointOf& point) {
  const Vec3<double> origin = point(triangles[0][0]);
  double size = 0;
  for (const auto& t : triangles)
    for (const uint32_t v : t) size = std::max(size, largest_component(point(v) - origin));
  if (!(size >= 0x1p-1000 && size <= 0x1p1000)) return 0;
  const double scale = std::ldexp(1, -std::ilogb(size) - 1);
  double volume = 0, magnitudes = 0;
  for (const auto& t : triangles) {
    const Vec3<double> a = scale * (point(t[0]) - origin), b = scale * (point(t[1]) - origin),
                       c = scale * (point(t[2]) - origin);
    volume += triple(a, b, c);
    const auto sum_of = [](double x, double y, double z, double w) { return magnitude(x * y) + magnitude(z * w); };
    magnitudes += magnitude(c.x) * sum_of(a.y, b.z, a.z, b.y) + magnitude(c.y) * sum_of(a.z, b.x, a.x, b.z) +
                  magnitude(c.z) * sum_of(a.x, b.y, a.y, b.x);
  }
  const double n = static_cast<double>(triangles.size());
  const double error = 0x1p-52 * (n + 8) * magnitudes + 0x1p-1068 * n;
  return volume > error ? 1 : volume < -error ? -1 : 0;
}

int exact_sign(Triangles triangles, const PointOf& point) {
  exact::Unit unit;
  for (const auto& t : triangles)
    for (const uint32_t v : t) unit.see(point(v));
  const Vec3<Number> origin = unit(point(triangles[0][0]));
  Number volume;
  for (const auto& t : triangles) {
    exact::PollScope::step();
    const auto corner = [&](size_t i) { return unit(point(t[i])) - origin; };
    volume += wide_dot(corner(0), wide_cross(corner(1), corner(2)));
  }
  return volume.sign();
}

}  // namespace

int sign_of_volume(Triangles triangles, const PointOf& point) {
  if (triangles.empty()) return 0;
  const int sign = rough_sign(triangles, point);
  return sign != 0 ? sign : exact_sign(triangles, point);
}

}  // namespace collided
