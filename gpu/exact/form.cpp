#include "gpu/exact/form.hpp"

#include <algorithm>

namespace collided::exact {
namespace {

/// f times (from s + to t).
Form times_linear(const Form& f, const mpz_class& from, const mpz_class& to) {
  Form product;
  product.c.assign(f.c.size() + 1, mpz_class(0));
  for (size_t i = 0; i < f.c.size(); ++i) {
    mpz_addmul(product.c[i].get_mpz_t(), f.c[i].get_mpz_t(), from.get_mpz_t());
    mpz_addmul(product.c[i + 1].get_mpz_t(), f.c[i].get_mpz_t(), to.get_mpz_t());
  }
  return product;
}

}  // namespace

bool Form::vanishes() const {
  return std::all_of(c.begin(), c.end(), [](const mpz_class& x) { return x == 0; });
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
  for (mpz_class& x : a.c) x = -x;
  return a;
}

Form operator*(const Form& a, const Form& b) {
  Form product;
  product.c.resize(a.c.size() + b.c.size() - 1);
  for (size_t i = 0; i < a.c.size(); ++i)
    for (size_t j = 0; j < b.c.size(); ++j)
      mpz_addmul(product.c[i + j].get_mpz_t(), a.c[i].get_mpz_t(), b.c[j].get_mpz_t());
  return product;
}

// Horner's rule in t / s, with the powers of s made on the way.
mpz_class value_at_point(const Form& f, const Dyadic& at) {
  const mpz_class s = (mpz_class(1) << at.bits) - at.k;
  mpz_class value = f.c.back(), power = 1;
  for (size_t i = f.degree(); i-- > 0;) {
    power *= s;
    value *= at.k;
    mpz_addmul(value.get_mpz_t(), f.c[i].get_mpz_t(), power.get_mpz_t());
  }
  return value;
}

// As above, with the linear forms that t and s are in the local parameter.
Form restricted(const Form& f, const Dyadic& on) {
  const mpz_class s0 = (mpz_class(1) << on.bits) - on.k, s1 = s0 - 1, t1 = on.k + 1;
  Form value, power;
  value.c = {f.c.back()};
  power.c = {mpz_class(1)};
  for (size_t i = f.degree(); i-- > 0;) {
    power = times_linear(power, s0, s1);
    value = times_linear(value, on.k, t1);
    for (size_t j = 0; j < value.c.size(); ++j)
      mpz_addmul(value.c[j].get_mpz_t(), f.c[i].get_mpz_t(), power.c[j].get_mpz_t());
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
  for (const mpz_class& x : f.c) {
    const int sign = sgn(x);
    changes += sign * last < 0;
    if (sign != 0) last = sign;
  }
  return changes;
}

int first_sign(const Form& f) {
  for (const mpz_class& x : f.c)
    if (x != 0) return sgn(x);
  return 0;
}

int open_sign(const Form& f) { return sign_changes(f) == 0 ? first_sign(f) : 0; }

int closed_sign(const Form& f) { return f.c.front() != 0 && f.c.back() != 0 ? open_sign(f) : 0; }

}  // namespace collided::exact
