#pragma once
// Integer polynomials on [0, 1] as forms of s = 1 - t and t: sum of c[k] s^(d-k) t^k, the Bernstein form without its
// binomials. Products are convolutions, the ends are c[0] and c[d], and the signs of the coefficients bound the roots
// in (0, 1) by Descartes' rule. Sums need equal degrees, so a constant that moves along is {c, c}.

#include <vector>

#include "gpu/exact/number.hpp"

namespace collided::exact {

/// Form of degree c.size() - 1; never empty.
struct Form {
  std::vector<Number> c{Number()};

  size_t degree() const { return c.size() - 1; }
  bool vanishes() const;
};

Form operator+(Form a, const Form& b);
Form operator-(Form a, const Form& b);
Form operator-(Form a);
Form operator*(const Form& a, const Form& b);

/// The dyadic interval [k, k + 1] / 2^bits, or its lower end.
struct Dyadic {
  Number k;
  mp_bitcnt_t bits = 0;
};

/// f without factors s + t, which is 1, and without powers of two that divide all coefficients. Forms of features that
/// do not turn lose most of their degree.
Form reduced(Form f);

/// The same without factors s and t, too: f's roots in (0, 1), and its sign between them. f must not vanish.
Form without_roots_at_ends(Form f);

/// f at t / (s + t), times (s + t)^degree.
Number value_at_ratio(const Form& f, const Number& s, const Number& t);

/// f at the lower end of `at`, which lies in [0, 1], times 2^(at.bits * degree).
Number value_at_point(const Form& f, const Dyadic& at);
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
