#include "gpu/exact/form.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace collided::exact {
namespace {

/// f times (from s + to t).
Form times_linear(const Form& f, const Number& from, const Number& to) {
  Form product;
  product.c.resize(f.c.size() + 1);
  for (size_t i = 0; i < f.c.size(); ++i) {
    product.c[i].add_product(f.c[i], from);
    product.c[i + 1].add_product(f.c[i], to);
  }
  return product;
}

/// Divides f by s + t if it is a divisor: if f at t / s = -1 is 0.
bool divide_by_one(Form& f) {
  if (f.degree() == 0) return false;
  Form quotient;
  quotient.c.resize(f.degree());
  Number next;
  for (size_t i = 0; i < quotient.c.size(); ++i) quotient.c[i] = next = f.c[i] - next;
  if (next != f.c.back()) return false;
  f = std::move(quotient);
  return true;
}

}  // namespace

bool Form::vanishes() const {
  return std::all_of(c.begin(), c.end(), [](const Number& x) { return x.is_zero(); });
}

Form operator+(Form a, const Form& b) {
  for (size_t i = 0; i < a.c.size(); ++i) a.c[i] += b.c[i];
  return a;
}

Form operator-(Form a, const Form& b) {
  for (size_t i = 0; i < a.c.size(); ++i) a.c[i] -= b.c[i];
  return a;
}

Form operator-(Form a) {
  for (Number& x : a.c) x.negate();
  return a;
}

Form operator*(const Form& a, const Form& b) {
  Form product;
  product.c.resize(a.c.size() + b.c.size() - 1);
  for (size_t i = 0; i < a.c.size(); ++i)
    for (size_t j = 0; j < b.c.size(); ++j) product.c[i + j].add_product(a.c[i], b.c[j]);
  return product;
}

Form reduced(Form f) {
  if (f.vanishes()) return Form();
  while (divide_by_one(f)) {
  }
  mp_bitcnt_t zeros = std::numeric_limits<mp_bitcnt_t>::max();
  for (const Number& x : f.c)
    if (!x.is_zero()) zeros = std::min(zeros, x.trailing_zeros());
  for (Number& x : f.c) x >>= zeros;
  return f;
}

Form without_roots_at_ends(Form f) {
  while (f.c.back().is_zero()) f.c.pop_back();
  f.c.erase(f.c.begin(), std::find_if(f.c.begin(), f.c.end(), [](const Number& x) { return !x.is_zero(); }));
  return reduced(std::move(f));
}

// Horner's rule in t / s, with the powers of s made on the way.
Number value_at_ratio(const Form& f, const Number& s, const Number& t) {
  Number value = f.c.back(), power = 1;
  for (size_t i = f.degree(); i-- > 0;) {
    power = power * s;
    value = value * t;
    value.add_product(f.c[i], power);
  }
  return value;
}
Number value_at_point(const Form& f, const Dyadic& at) {
  return value_at_ratio(f, (Number(1) << at.bits) - at.k, at.k);
}

// As above, with the linear forms that t and s are in the local parameter.
Form restricted(const Form& f, const Dyadic& on) {
  const Number s0 = (Number(1) << on.bits) - on.k, s1 = s0 - 1, t1 = on.k + 1;
  Form value, power;
  value.c[0] = f.c.back();
  power.c[0] = 1;
  for (size_t i = f.degree(); i-- > 0;) {
    power = times_linear(power, s0, s1);
    value = times_linear(value, on.k, t1);
    for (size_t j = 0; j < value.c.size(); ++j) value.c[j].add_product(f.c[i], power.c[j]);
  }
  return value;
}

// t = (s' + 2 t') / 2 and s = s' / 2: a Taylor shift by one, then powers of two.
Form right_half(const Form& f) {
  Form half = f;
  const size_t d = f.degree();
  for (size_t i = 0; i < d; ++i)
    for (size_t j = d; j-- > i;) half.c[j] += half.c[j + 1];
  for (size_t j = 1; j <= d; ++j) half.c[j] <<= j;
  return half;
}

Form left_half(const Form& f) {
  Form mirrored = f;
  std::reverse(mirrored.c.begin(), mirrored.c.end());
  mirrored = right_half(mirrored);
  std::reverse(mirrored.c.begin(), mirrored.c.end());
  return mirrored;
}

int sign_changes(const Form& f) {
  int changes = 0, last = 0;
  for (const Number& x : f.c) {
    const int sign = sgn(x);
    changes += sign * last < 0;
    if (sign != 0) last = sign;
  }
  return changes;
}

int first_sign(const Form& f) {
  for (const Number& x : f.c)
    if (!x.is_zero()) return sgn(x);
  return 0;
}

int open_sign(const Form& f) { return sign_changes(f) == 0 ? first_sign(f) : 0; }

int closed_sign(const Form& f) { return f.c.front().is_zero() || f.c.back().is_zero() ? 0 : open_sign(f); }

}  // namespace collided::exact
