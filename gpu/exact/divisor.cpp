#include "gpu/exact/divisor.hpp"

#include <utility>

#include "gpu/exact/poll.hpp"

namespace collided::exact {
namespace {

/// Without leading zeros and without the coefficients' common factor; the degree is then the true one.
Form primitive(Form f) {
  while (f.c.size() > 1 && f.c.back() == 0) f.c.pop_back();
  mpz_class content = 0;
  for (const mpz_class& x : f.c) {
    mpz_gcd(content.get_mpz_t(), content.get_mpz_t(), x.get_mpz_t());
    if (content == 1) return f;
  }
  if (content != 0)
    for (mpz_class& x : f.c) mpz_divexact(x.get_mpz_t(), x.get_mpz_t(), content.get_mpz_t());
  return f;
}

/// Quotient and remainder of l^(m+1) a by b, l the leading coefficient of b and m the quotient's degree (Knuth, volume
/// 2, section 4.6.1, algorithm R). Neither has leading zeros, and deg a >= deg b.
std::pair<Form, Form> pseudo_divide(Form a, const Form& b) {
  const size_t n = b.degree(), m = a.degree() - n;
  const mpz_class& lead = b.c.back();
  Form quotient;
  quotient.c.resize(m + 1);
  for (size_t k = m + 1; k-- > 0;) {
    const mpz_class top = a.c[n + k];
    for (size_t j = k + 1; j <= m; ++j) quotient.c[j] *= lead;
    quotient.c[k] = top;
    for (size_t j = 0; j < n + k; ++j) a.c[j] *= lead;
    for (size_t j = 0; j < n; ++j) a.c[k + j] -= top * b.c[j];
    a.c.pop_back();
  }
  if (a.c.empty()) a.c.emplace_back(0);
  return {std::move(quotient), std::move(a)};
}

Form derivative(const Form& f) {
  Form d;
  d.c.assign(f.c.begin() + 1, f.c.end());
  for (size_t i = 0; i < d.c.size(); ++i) d.c[i] *= static_cast<unsigned long>(i + 1);
  return d;
}

}  // namespace

// Euclid's algorithm with primitive remainders.
Form common_divisor(const Form& a, const Form& b) {
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

Form square_free(const Form& f) {
  const Form whole = primitive(f);
  if (whole.degree() == 0) return whole;
  const Form repeated = common_divisor(whole, derivative(whole));
  return repeated.degree() == 0 ? whole : primitive(pseudo_divide(whole, repeated).first);
}

}  // namespace collided::exact
