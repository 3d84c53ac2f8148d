#pragma once
// Forms as in exact/form.hpp, with coefficients of fixed size. Decisions with a thickness spend most of their time on
// making forms and looking at their coefficients' signs. No coefficient is above the form's value at s = t = 1, taken
// with all signs positive. There coordinates are below 2^(64 W - 3), so products of six fit by the bounds of
// differences.hpp with one bit more for each factor.

#include "gpu/exact/fixed/integer.hpp"

namespace collided::exact::fixed {

/// sum of c[k] s^(degree - k) t^k.
template <int degree, int N>
struct Polynomial {
  Integer<N> c[degree + 1];

  bool vanishes() const {
    bool all = true;
    for (const Integer<N>& x : c) all = all && x.is_zero();
    return all;
  }
};

template <int degree, int N>
Polynomial<degree, N> operator+(const Polynomial<degree, N>& a, const Polynomial<degree, N>& b) {
  Polynomial<degree, N> sum;
  for (int i = 0; i <= degree; ++i) sum.c[i] = a.c[i] + b.c[i];
  return sum;
}
template <int degree, int N>
Polynomial<degree, N> operator-(const Polynomial<degree, N>& a, const Polynomial<degree, N>& b) {
  Polynomial<degree, N> difference;
  for (int i = 0; i <= degree; ++i) difference.c[i] = a.c[i] - b.c[i];
  return difference;
}
template <int degree, int N>
Polynomial<degree, N> operator-(const Polynomial<degree, N>& a) {
  return Polynomial<degree, N>{} - a;
}
template <int d1, int N1, int d2, int N2>
Polynomial<d1 + d2, N1 + N2> operator*(const Polynomial<d1, N1>& a, const Polynomial<d2, N2>& b) {
  Polynomial<d1 + d2, N1 + N2> product{};
  for (int i = 0; i <= d1; ++i)
    for (int j = 0; j <= d2; ++j) product.c[i + j] = product.c[i + j] + a.c[i] * b.c[j];
  return product;
}

/// Returns what closed_sign of exact/form.hpp does.
template <int degree, int N>
int closed_sign(const Polynomial<degree, N>& f) {
  const int first = f.c[0].sign();
  if (first == 0 || f.c[degree].sign() == 0) return 0;
  for (const Integer<N>& x : f.c)
    if (x.sign() * first < 0) return 0;
  return first;
}

}  // namespace collided::exact::fixed
