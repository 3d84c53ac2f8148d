#include "gpu/positions/rigid_arc.hpp"

#include <algorithm>
#include <cmath>

namespace collided {
namespace {

using Vec = Vec3<double>;

double length(const Vec& v) { return std::sqrt(dot(v, v)); }

Vec at(const Pose& p, const Vec& x) {
  const auto row = [&](int i) { return p.r(i, 0) * x.x + p.r(i, 1) * x.y + p.r(i, 2) * x.z + p.t(i); };
  return {row(0), row(1), row(2)};
}

/// R of `to` times the transpose of R of `from`.
struct Turn {
  double m[3][3];

  Turn(const Pose& from, const Pose& to) {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        m[i][k] = 0;
        for (int j = 0; j < 3; ++j) m[i][k] += to.r(i, j) * from.r(k, j);
      }
  }
  /// |R - I| = 2 sqrt(2) sin(angle / 2), by the Frobenius norm.
  double angle() const {
    double sum = 0;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) sum += (m[i][k] - (i == k)) * (m[i][k] - (i == k));
    return 2 * std::asin(std::min(1.0, std::sqrt(sum / 8)));
  }
  /// The axis times 2 sin(angle).
  Vec axis() const { return {m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]}; }
};

/// Corners of a box; a norm of an affine function is nowhere larger than at one of them.
Vec corner_of(const Box<double>& box, int i) {
  return {i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z};
}
template <class Size>
double largest_of_corners(const Box<double>& box, const Size& size) {
  double largest = 0;
  for (int i = 0; i < 8; ++i) largest = std::max(largest, size(corner_of(box, i)));
  return largest;
}

}  // namespace

double angle_between(const Pose& from, const Pose& to) { return Turn(from, to).angle(); }

double largest_coordinate(const Pose& pose, const Box<double>& rest) {
  return largest_of_corners(rest, [&](const Vec& x) { return largest_component(at(pose, x)); }) * (1 + 0x1p-48);
}

double arc_deviation(const Pose& from, const Pose& to, const Box<double>& rest, double unit) {
  if (from.has_rotation_of(to)) return 0;
  constexpr double kSafe = 1 + 0x1p-30;  // for the roundings of what follows
  const Turn turn(from, to);
  const double angle = turn.angle();
  // Only what a vertex moves across the axis is part of its arc. An axis of next to no turn is next to no direction.
  const Vec axis = turn.axis();
  const double along = length(axis) > 1e-3 ? 1 / length(axis) : 0;
  const double across = largest_of_corners(rest, [&](const Vec& x) {
    const Vec way = at(to, x) - at(from, x);
    const double advance = along * dot(axis, way);
    return std::sqrt(std::max(0.0, dot(way, way) - advance * advance)) + 0x1p-36 * length(way);
  });
  const double way = largest_of_corners(rest, [&](const Vec& x) { return length(at(to, x) - at(from, x)); });
  const double far = largest_of_corners(rest, length);
  const double reach = std::max(largest_of_corners(rest, [&](const Vec& x) { return length(at(from, x)); }),
                                largest_of_corners(rest, [&](const Vec& x) { return length(at(to, x)); }));
  // across = 2 r sin(angle / 2).
  const double arc = angle > 0 ? across * angle * (angle / (16 * std::sin(angle / 2))) : 0;
  const double defect = std::max(rotation_defect(from), rotation_defect(to)) + 0x1p-48;
  return (arc + defect * (8 * far + 16 * way) + 4 * unit * (reach + far)) * kSafe;
}

}  // namespace collided
