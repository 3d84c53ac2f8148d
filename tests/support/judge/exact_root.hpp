#pragma once
// Real roots of integer polynomials in [0, 1] as exact numbers: isolating intervals, and the sign of any other
// polynomial there.
//
// Descartes' rule, in the form of Vincent, Collins and Akritas: the sign changes among the Bernstein coefficients of a
// polynomial on an interval are its roots inside (counted with multiplicity) or more by an even number. None means no
// root and one means exactly one; bisection of a polynomial with simple roots ends at one of the two.

#include <vector>

#include "tests/support/judge/exact_polynomial.hpp"

namespace collided::test {

/// A root of a polynomial: the fraction k / 2^m itself, or the only root in the open interval (k, k+1) / 2^m.
class Root {
 public:
  /// `local`(s) is a positive multiple of polynomial((k+s) / 2^m), with exactly one root in 0 < s < 1.
  Root(Polynomial polynomial, Polynomial local, mpz_class k, unsigned m);
  Root(Polynomial polynomial, mpz_class k, unsigned m);

  mpq_class lower() const;
  mpq_class upper() const;
  bool is_fraction() const { return is_fraction_; }
  void refine(unsigned bits);  ///< until the interval is no wider than 2^-bits

  /// The sign of `g` at the root: exact, and 0 only where g is 0. May refine the interval.
  int sign_of(const Polynomial& g);

 private:
  void bisect();
  bool is_root_of(const Polynomial& divisor) const;

  Polynomial polynomial_;
  Polynomial local_;
  mpz_class k_;
  unsigned m_;
  bool is_fraction_;
};

/// Sign changes among the Bernstein coefficients on [0, 1]; 0 means that the polynomial has one sign in (0, 1), and the
/// sign is then that of any coefficient.
int sign_changes(const Polynomial& p);

/// All roots in the closed interval [0, 1], ascending, each once. The zero polynomial has none.
std::vector<Root> roots_in_unit_interval(const Polynomial& p);

}  // namespace collided::test
