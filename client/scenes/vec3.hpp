#pragma once
// Arithmetic on positions and directions.

#include <cmath>

#include "client/scenes/scene.hpp"

namespace collided::scenes {

inline Vec3d plus(const Vec3d& a, const Vec3d& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3d minus(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3d times(const Vec3d& a, double s) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec3d& a) { return std::sqrt(dot(a, a)); }
inline Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// Of a vector that is not zero.
inline Vec3d unit(const Vec3d& a) {
  const double l = length(a);
  return {a[0] / l, a[1] / l, a[2] / l};
}
/// `a` at t = 0, `b` at t = 1.
inline Vec3d between(const Vec3d& a, const Vec3d& b, double t) {
  return {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1], (1 - t) * a[2] + t * b[2]};
}

}  // namespace collided::scenes
