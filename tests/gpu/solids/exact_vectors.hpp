#pragma once
// Vectors of integers, in numbers of 128 bits where coordinates are small, else in numbers of any size.

#include <gmpxx.h>

#include <array>

namespace collided::test {

__extension__ typedef __int128 Int128;

inline int sign(const Int128& x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }
inline int sign(const mpz_class& x) { return sgn(x); }

inline mpz_class big(const mpz_class& x) { return x; }
inline mpz_class big(const Int128& x) {
  const Int128 magnitude = x < 0 ? -x : x;
  mpz_class value = static_cast<unsigned long>(magnitude >> 64);
  value <<= 64;
  value += static_cast<unsigned long>(magnitude);
  return x < 0 ? mpz_class(-value) : value;
}

template <class N>
using Vector = std::array<N, 3>;

template <class N>
Vector<N> operator-(const Vector<N>& a, const Vector<N>& b) {
  return {N(a[0] - b[0]), N(a[1] - b[1]), N(a[2] - b[2])};
}
template <class N>
Vector<N> operator+(const Vector<N>& a, const Vector<N>& b) {
  return {N(a[0] + b[0]), N(a[1] + b[1]), N(a[2] + b[2])};
}
template <class N>
Vector<N> times(const Vector<N>& a, const N& factor) {
  return {N(a[0] * factor), N(a[1] * factor), N(a[2] * factor)};
}
template <class N>
N dot(const Vector<N>& a, const Vector<N>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class N>
Vector<N> cross(const Vector<N>& a, const Vector<N>& b) {
  return {N(a[1] * b[2] - a[2] * b[1]), N(a[2] * b[0] - a[0] * b[2]), N(a[0] * b[1] - a[1] * b[0])};
}
template <class N>
bool is_zero(const Vector<N>& a) {
  return sign(a[0]) == 0 && sign(a[1]) == 0 && sign(a[2]) == 0;
}

/// `under` > 0.
template <class N>
struct Fraction {
  N over, under;

  bool operator<(const Fraction& other) const { return over * other.under < other.over * under; }
  bool operator==(const Fraction& other) const { return over * other.under == other.over * under; }
};

template <class N>
struct Triangle {
  Vector<N> a, b, c;

  Vector<N> normal() const { return cross(b - a, c - a); }
  Triangle from(const Vector<N>& origin) const { return {a - origin, b - origin, c - origin}; }
  /// Its sides, each from a corner to the next.
  std::array<std::array<Vector<N>, 2>, 3> sides() const {
    return {std::array{a, b}, std::array{b, c}, std::array{c, a}};
  }
};

}  // namespace collided::test
