#pragma once
// Polynomials in one unknown with integer coefficients of any size: nothing is ever rounded.

#include <gmpxx.h>

#include <array>
#include <initializer_list>
#include <vector>

namespace collided::test {

/// Coefficients from the constant one up, without leading zeros: the zero polynomial has none.
class Polynomial {
 public:
  Polynomial() = default;
  Polynomial(std::initializer_list<mpz_class> coefficients) : Polynomial(std::vector<mpz_class>(coefficients)) {}
  explicit Polynomial(std::vector<mpz_class> coefficients);

  bool is_zero() const { return c_.empty(); }
  int degree() const { return static_cast<int>(c_.size()) - 1; }  ///< -1: the zero polynomial
  const std::vector<mpz_class>& coefficients() const { return c_; }
  int sign_at_zero() const { return c_.empty() ? 0 : sgn(c_[0]); }
  int sign_at_one() const;

  Polynomial derivative() const;
  /// The same up to a positive factor, with coefficients that have no common divisor.
  Polynomial primitive() const;

  friend Polynomial operator+(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator-(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator*(const mpz_class& factor, const Polynomial& p);

 private:
  std::vector<mpz_class> c_;
};

/// The greatest common divisor over the rationals, up to a factor; gcd(0, b) = b.
Polynomial gcd(Polynomial a, Polynomial b);

/// A polynomial with the roots of `p`, each of them simple.
Polynomial square_free(const Polynomial& p);

/// A point or vector whose coordinates are polynomials in time.
using PolynomialVector = std::array<Polynomial, 3>;

PolynomialVector operator-(const PolynomialVector& a, const PolynomialVector& b);
PolynomialVector cross(const PolynomialVector& a, const PolynomialVector& b);
Polynomial dot(const PolynomialVector& a, const PolynomialVector& b);

}  // namespace collided::test
