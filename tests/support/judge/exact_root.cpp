#include "tests/support/judge/exact_root.hpp"

#include <algorithm>
#include <utility>

namespace collided::test {
namespace {

// p(s + k)
std::vector<mpz_class> shifted(std::vector<mpz_class> c, const mpz_class& k) {
  for (size_t i = 0; i + 1 < c.size(); ++i)
    for (size_t j = c.size() - 1; j-- > i;) mpz_addmul(c[j].get_mpz_t(), c[j + 1].get_mpz_t(), k.get_mpz_t());
  return c;
}

std::vector<mpz_class> shifted_by_one(std::vector<mpz_class> c) {
  for (size_t i = 0; i + 1 < c.size(); ++i)
    for (size_t j = c.size() - 1; j-- > i;) c[j] += c[j + 1];
  return c;
}

// 2^(m * degree) * p(s / 2^m)
std::vector<mpz_class> stretched(std::vector<mpz_class> c, unsigned m) {
  for (size_t i = 0; i < c.size(); ++i) c[i] <<= m * (c.size() - 1 - i);
  return c;
}

// A positive multiple of p on the interval (k, k+1) / 2^m, as a polynomial on (0, 1).
Polynomial on_interval(const Polynomial& p, const mpz_class& k, unsigned m) {
  return Polynomial(shifted(stretched(p.coefficients(), m), k));
}

// Binomial multiples of the Bernstein coefficients on [0, 1], last first: those of (1 + s)^degree * p(1 / (1 + s)).
std::vector<mpz_class> bernstein(const Polynomial& p) {
  std::vector<mpz_class> c = p.coefficients();
  std::reverse(c.begin(), c.end());
  return shifted_by_one(std::move(c));
}

// The sign right of s = 0.
int leading_sign(const Polynomial& p) {
  for (const mpz_class& value : p.coefficients())
    if (value != 0) return sgn(value);
  return 0;
}

mpq_class fraction(const mpz_class& k, unsigned m) {
  mpq_class q(k);
  mpq_div_2exp(q.get_mpq_t(), q.get_mpq_t(), m);
  return q;
}

struct Isolation {
  const Polynomial& polynomial;
  std::vector<Root>& roots;

  // Roots in the open interval (k, k+1) / 2^m.
  void search(const Polynomial& local, const mpz_class& k, unsigned m) {
    const int changes = sign_changes(local);
    if (changes == 0) return;
    if (changes == 1) {
      roots.emplace_back(polynomial, local, k, m);
      return;
    }
    const Polynomial left(stretched(local.coefficients(), 1));
    const Polynomial right(shifted_by_one(left.coefficients()));
    const mpz_class middle = 2 * k + 1;
    search(left, 2 * k, m + 1);
    if (right.sign_at_zero() == 0) roots.emplace_back(polynomial, middle, m + 1);
    search(right, middle, m + 1);
  }
};

}  // namespace

Root::Root(Polynomial polynomial, Polynomial local, mpz_class k, unsigned m)
    : polynomial_(std::move(polynomial)), local_(std::move(local)), k_(std::move(k)), m_(m), is_fraction_(false) {}

Root::Root(Polynomial polynomial, mpz_class k, unsigned m)
    : polynomial_(std::move(polynomial)), k_(std::move(k)), m_(m), is_fraction_(true) {}

mpq_class Root::lower() const { return fraction(k_, m_); }
mpq_class Root::upper() const { return fraction(is_fraction_ ? k_ : mpz_class(k_ + 1), m_); }

void Root::refine(unsigned bits) {
  while (!is_fraction_ && m_ < bits) bisect();
}

void Root::bisect() {
  const int before = leading_sign(local_);
  Polynomial left(stretched(local_.coefficients(), 1));
  Polynomial right(shifted_by_one(left.coefficients()));
  const int middle = right.sign_at_zero();
  k_ *= 2;
  ++m_;
  if (middle == before || middle == 0) ++k_;
  if (middle == 0) is_fraction_ = true;
  local_ = middle == before ? std::move(right) : std::move(left);
}

// The roots of a divisor are roots of the polynomial, and so at most this one, simple, within the interval.
bool Root::is_root_of(const Polynomial& divisor) const { return sign_changes(on_interval(divisor, k_, m_)) % 2 == 1; }

int Root::sign_of(const Polynomial& g) {
  constexpr unsigned kTrials[] = {12, 28, 56};  // bits that decide nearly all signs before a gcd has to
  const auto decided = [&](int& sign) {
    const Polynomial local = on_interval(g, k_, m_);
    sign = is_fraction_ ? local.sign_at_zero() : leading_sign(local);
    return is_fraction_ || sign_changes(local) == 0;
  };
  int sign = 0;
  for (const unsigned bits : kTrials) {
    refine(bits);
    if (decided(sign)) return sign;
  }
  if (is_root_of(gcd(polynomial_, g))) return 0;
  while (!decided(sign)) refine(2 * m_);
  return sign;
}

int sign_changes(const Polynomial& p) {
  int changes = 0, last = 0;
  for (const mpz_class& value : bernstein(p)) {
    const int sign = sgn(value);
    if (sign != 0 && last != 0 && sign != last) ++changes;
    if (sign != 0) last = sign;
  }
  return changes;
}

std::vector<Root> roots_in_unit_interval(const Polynomial& p) {
  std::vector<Root> roots;
  if (p.degree() < 1) return roots;
  const int changes = sign_changes(p);
  if (p.sign_at_zero() == 0) roots.emplace_back(p, 0, 0);
  if (changes == 1) roots.emplace_back(p, p, 0, 0);
  if (changes > 1) {
    const Polynomial simple = square_free(p);
    Isolation{simple, roots}.search(simple, 0, 0);
  }
  if (p.sign_at_one() == 0) roots.emplace_back(p, 1, 0);
  return roots;
}

}  // namespace collided::test
