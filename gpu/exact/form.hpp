#pragma once
// Integer polynomials on [0, 1] as forms of s = 1 - t and t: sum of c[k] s^(d-k) t^k, the Bernstein form without its
// binomials. Products are convolutions, the ends are c[0] and c[d], and the signs of the coefficients bound the roots
// in (0, 1) by Descartes' rule. Sums need equal degrees, so a constant that moves along is {c, c}.

#include <gmpxx.h>

#include <vector>

namespace collided::exact {

/// Form of degree c.size() - 1; never empty.
struct Form {
  std::vector<mpz_class> c{mpz_class(0)};

  size_t degree() const { return c.size() - 1; }
  bool vanishes() const;
};

Form operator+(Form a, const Form& b);
Form operator-(Form a, const Form& b);
Form operator-(Form a);
Form operator*(const Form& a, const Form& b);

/// The dyadic interval [k, k + 1] / 2^bits, or its lower end.
struct Dyadic {
  mpz_class k = 0;
  mp_bitcnt_t bits = 0;
};

/// f at the lower end of `at`, which lies in [0, 1], times 2^(at.bits * degree).
mpz_class value_at_point(const Form& f, const Dyadic& at);
inline int sign_at_point(const Form& f, const Dyadic& at) { return sgn(value_at_point(f, at)); }

/// f in the local parameter of the interval `on`, but for a positive factor.
Form restricted(const Form& f, const Dyadic& on);

/// f on [0, 1/2] and on [1/2, 1], each in its local parameter, but for a common positive factor.
Form left_half(const Form& f);
Form right_half(const Form& f);

/// Changes of sign along the coefficients, zeros left out: the number of roots in (0, 1) plus an even number.
int sign_changes(const Form& f);

/// The first coefficient's sign that is not zero: that of f just right of 0. 0 if f vanishes.
int first_sign(const Form& f);

/// The sign of f all over (0, 1) if the coefficients agree on one; else 0.
int open_sign(const Form& f);

/// The sign of f all over [0, 1] if the coefficients agree on one and neither end is a root; else 0.
int closed_sign(const Form& f);

}  // namespace collided::exact
