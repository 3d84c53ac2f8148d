#include "gpu/exact/roots/divisor.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "gpu/exact/poll.hpp"

namespace collided::exact {
namespace {

/// Without leading zeros and without the coefficients' common factor; the degree is then the true one.
Form primitive(Form f) {
  while (f.c.size() > 1 && f.c.back().is_zero()) f.c.pop_back();
  Number content;
  for (const Number& x : f.c) {
    content = common_divisor(content, x);
    if (content == 1) return f;
  }
  if (!content.is_zero())
    for (Number& x : f.c) x = exact_quotient(x, content);
  return f;
}

/// Quotient and remainder of l^(m+1) a by b, l the leading coefficient of b and m the quotient's degree (Knuth, volume
/// 2, section 4.6.1, algorithm R). Neither has leading zeros, and deg a >= deg b.
std::pair<Form, Form> pseudo_divide(Form a, const Form& b) {
  const size_t n = b.degree(), m = a.degree() - n;
  const Number& lead = b.c.back();
  Form quotient;
  quotient.c.resize(m + 1);
  for (size_t k = m + 1; k-- > 0;) {
    const Number top = a.c[n + k];
    for (size_t j = k + 1; j <= m; ++j) quotient.c[j] = quotient.c[j] * lead;
    quotient.c[k] = top;
    for (size_t j = 0; j < n + k; ++j) a.c[j] = a.c[j] * lead;
    for (size_t j = 0; j < n; ++j) a.c[k + j] -= top * b.c[j];
    a.c.pop_back();
  }
  if (a.c.empty()) a.c.emplace_back();
  return {std::move(quotient), std::move(a)};
}

/// Polynomials over the integers modulo a prime below 2^31; no leading zeros, empty for 0.
namespace modular {

constexpr uint64_t kPrime = 2147483647;
using Polynomial = std::vector<uint64_t>;

void trim(Polynomial& f) {
  while (!f.empty() && f.back() == 0) f.pop_back();
}
Polynomial of(const Form& f) {
  Polynomial residues;
  for (const Number& x : f.c) residues.push_back(exact::remainder(x, kPrime));
  trim(residues);
  return residues;
}
/// By Fermat.
uint64_t inverse(uint64_t x) {
  uint64_t result = 1;
  for (uint64_t e = kPrime - 2; e != 0; e >>= 1, x = x * x % kPrime)
    if ((e & 1) != 0) result = result * x % kPrime;
  return result;
}
Polynomial remainder(Polynomial a, const Polynomial& b) {
  const uint64_t by = inverse(b.back());
  while (a.size() >= b.size()) {
    const uint64_t times = kPrime - a.back() * by % kPrime;
    const size_t shift = a.size() - b.size();
    for (size_t k = 0; k < b.size(); ++k) a[shift + k] = (a[shift + k] + times * b[k]) % kPrime;
    trim(a);
  }
  return a;
}

/// Degree of the greatest common divisor. a is not 0.
size_t common_degree(Polynomial a, Polynomial b) {
  while (!b.empty()) {
    Polynomial rest = remainder(std::move(a), b);
    a = std::move(b);
    b = std::move(rest);
  }
  return a.size() - 1;
}

}  // namespace modular

/// Whether a simple look shows that a and b have no common divisor but numbers; if not, they mostly have one. A
/// divisor's leading coefficient divides that of a. If the prime does not divide the one, it does not divide the other:
/// then the divisor, modulo the prime, is of the same degree and divides both.
bool are_seen_coprime(const Form& a, const Form& b) {
  const auto lead = std::find_if(a.c.rbegin(), a.c.rend(), [](const Number& x) { return !x.is_zero(); });
  const modular::Polynomial u = modular::of(a);
  const bool keeps_degree = !u.empty() && u.size() == static_cast<size_t>(a.c.rend() - lead);
  return keeps_degree && modular::common_degree(u, modular::of(b)) == 0;
}

Form derivative(const Form& f) {
  Form d;
  d.c.assign(f.c.begin() + 1, f.c.end());
  for (size_t i = 0; i < d.c.size(); ++i) d.c[i] = d.c[i] * static_cast<int64_t>(i + 1);
  return d;
}

}  // namespace

// Euclid's algorithm with primitive remainders, where there may be a divisor.
Form common_divisor(const Form& a, const Form& b) {
  if (are_seen_coprime(a, b)) return {{Number(1)}};
  Form u = primitive(a), v = primitive(b);
  if (u.degree() < v.degree() || u.vanishes()) std::swap(u, v);
  while (!v.vanishes()) {
    PollScope::step();
    Form remainder = primitive(pseudo_divide(std::move(u), v).second);
    u = std::move(v);
    v = std::move(remainder);
  }
  return u;
}

bool may_repeat(const Form& f) { return f.degree() > 1 && !are_seen_coprime(f, derivative(f)); }

Form square_free(const Form& f) {
  const Form whole = primitive(f);
  if (whole.degree() == 0) return whole;
  const Form repeated = common_divisor(whole, derivative(whole));
  return repeated.degree() == 0 ? whole : primitive(pseudo_divide(whole, repeated).first);
}

}  // namespace collided::exact
