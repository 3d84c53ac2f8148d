#pragma once
// Three-vectors of float or double, packed.

#include <cmath>

#include "gpu/base/host_device.hpp"

namespace collided {

template <class Real>
struct Vec3 {
  Real x, y, z;
};

template <class Real>
COLLIDED_HD Vec3<Real> operator-(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
COLLIDED_HD Vec3<Real> operator+(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
COLLIDED_HD Vec3<Real> operator*(Real s, const Vec3<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
COLLIDED_HD Real dot(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
COLLIDED_HD Vec3<Real> cross(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Determinant of the three columns.
template <class Real>
COLLIDED_HD Real triple(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c) {
  return dot(cross(a, b), c);
}

template <class To, class From>
COLLIDED_HD Vec3<To> convert(const Vec3<From>& v) {
  return {static_cast<To>(v.x), static_cast<To>(v.y), static_cast<To>(v.z)};
}

template <class T>
COLLIDED_HD T min(T a, T b) {
  return b < a ? b : a;
}
template <class T>
COLLIDED_HD T max(T a, T b) {
  return a < b ? b : a;
}
template <class T>
COLLIDED_HD T magnitude(T a) {
  return std::fabs(a);  // costs nothing where it is an operand of a sum or a product
}
template <class T>
COLLIDED_HD T square_root(T a) {
  return std::sqrt(a);
}
template <class Real>
COLLIDED_HD Real largest_component(const Vec3<Real>& a) {
  return max(magnitude(a.x), max(magnitude(a.y), magnitude(a.z)));
}

}  // namespace collided
