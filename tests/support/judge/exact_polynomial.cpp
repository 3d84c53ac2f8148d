#include "tests/support/judge/exact_polynomial.hpp"

#include <utility>

namespace collided::test {
namespace {

// The remainder of b^k * a by b for the smallest k that keeps it integer.
Polynomial pseudo_remainder(const Polynomial& a, const Polynomial& b) {
  std::vector<mpz_class> rest = a.coefficients();
  const std::vector<mpz_class>& divisor = b.coefficients();
  for (size_t n = rest.size(); n >= divisor.size(); --n) {
    const mpz_class lead = rest[n - 1];
    for (size_t i = 0; i < n; ++i) rest[i] *= divisor.back();
    for (size_t i = 0; i < divisor.size(); ++i) rest[n - divisor.size() + i] -= lead * divisor[i];
  }
  return Polynomial(std::move(rest));
}

// a / b up to a factor, where b divides a over the rationals.
Polynomial exact_quotient(const Polynomial& a, const Polynomial& b) {
  std::vector<mpz_class> rest = a.coefficients();
  const std::vector<mpz_class>& divisor = b.coefficients();
  std::vector<mpz_class> quotient(rest.size() - divisor.size() + 1);
  for (size_t k = quotient.size(); k-- > 0;) {
    const mpz_class lead = rest[k + divisor.size() - 1];
    for (mpz_class& value : rest) value *= divisor.back();
    for (mpz_class& value : quotient) value *= divisor.back();
    quotient[k] = lead;
    for (size_t i = 0; i < divisor.size(); ++i) rest[k + i] -= lead * divisor[i];
  }
  return Polynomial(std::move(quotient)).primitive();
}

template <class Combine>
Polynomial combined(const std::vector<mpz_class>& a, const std::vector<mpz_class>& b, const Combine& combine) {
  std::vector<mpz_class> sum = a;
  if (sum.size() < b.size()) sum.resize(b.size());
  for (size_t i = 0; i < b.size(); ++i) combine(sum[i], b[i]);
  return Polynomial(std::move(sum));
}

}  // namespace

Polynomial::Polynomial(std::vector<mpz_class> coefficients) : c_(std::move(coefficients)) {
  while (!c_.empty() && c_.back() == 0) c_.pop_back();
}

int Polynomial::sign_at_one() const {
  mpz_class sum;
  for (const mpz_class& value : c_) sum += value;
  return sgn(sum);
}

Polynomial Polynomial::derivative() const {
  std::vector<mpz_class> d;
  for (size_t i = 1; i < c_.size(); ++i) d.push_back(c_[i] * static_cast<unsigned long>(i));
  return Polynomial(std::move(d));
}

Polynomial Polynomial::primitive() const {
  mpz_class content;
  for (const mpz_class& value : c_) mpz_gcd(content.get_mpz_t(), content.get_mpz_t(), value.get_mpz_t());
  Polynomial p = *this;
  for (mpz_class& value : p.c_) mpz_divexact(value.get_mpz_t(), value.get_mpz_t(), content.get_mpz_t());
  return p;
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  return combined(a.c_, b.c_, [](mpz_class& x, const mpz_class& y) { x += y; });
}

Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  return combined(a.c_, b.c_, [](mpz_class& x, const mpz_class& y) { x -= y; });
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  if (a.is_zero() || b.is_zero()) return {};
  std::vector<mpz_class> product(a.c_.size() + b.c_.size() - 1);
  for (size_t i = 0; i < a.c_.size(); ++i)
    for (size_t j = 0; j < b.c_.size(); ++j)
      mpz_addmul(product[i + j].get_mpz_t(), a.c_[i].get_mpz_t(), b.c_[j].get_mpz_t());
  return Polynomial(std::move(product));
}

Polynomial operator*(const mpz_class& factor, const Polynomial& p) { return Polynomial{factor} * p; }

Polynomial gcd(Polynomial a, Polynomial b) {
  while (!b.is_zero()) {
    Polynomial rest = pseudo_remainder(a, b).primitive();
    a = std::exchange(b, std::move(rest));
  }
  return a.primitive();
}

Polynomial square_free(const Polynomial& p) {
  const Polynomial repeated = gcd(p, p.derivative());
  return repeated.degree() > 0 ? exact_quotient(p, repeated) : p;
}

PolynomialVector operator-(const PolynomialVector& a, const PolynomialVector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

PolynomialVector cross(const PolynomialVector& a, const PolynomialVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Polynomial dot(const PolynomialVector& a, const PolynomialVector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace collided::test
