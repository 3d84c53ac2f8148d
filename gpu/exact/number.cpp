#include "gpu/exact/number.hpp"

#include <cmath>

namespace collided::exact {
namespace {

template <class Operation>
Number by_gmp(Operation operation, const Number& a, const Number& b) {
  mpz_t result, x, y;
  mpz_init(result);
  operation(result, a.view(x), b.view(y));
  Number number = Number::of(result);
  mpz_clear(result);
  return number;
}

}  // namespace

void Number::reserve(int limbs, int kept) {
  if (limbs <= capacity_) return;
  const int capacity = std::max(limbs, 2 * capacity_);
  mp_limb_t* const larger = std::allocator<mp_limb_t>().allocate(static_cast<size_t>(capacity));
  std::copy_n(limbs_, kept, larger);
  release();
  limbs_ = larger;
  capacity_ = capacity;
}

void Number::assign(const mp_limb_t* from, int size) {
  const int limbs = size < 0 ? -size : size;
  reserve(limbs, 0);
  std::copy_n(from, limbs, limbs_);
  size_ = size;
}

double Number::to_double() const {
  mpz_t x;
  return mpz_get_d(view(x));
}

double Number::to_double(int64_t& exponent) const {
  mpz_t x;
  long bits = 0;
  const double rounded = mpz_get_d_2exp(&bits, view(x));
  exponent = bits;
  return rounded;
}

Number& Number::add(const mp_limb_t* b, int size) {
  const int m = count(), n = size < 0 ? -size : size;
  if (n == 0) return *this;
  const bool is_negative = size_ < 0, b_is_negative = size < 0;
  if (m == 0) {
    assign(b, size);
  } else if (is_negative == b_is_negative) {
    const int most = std::max(m, n);
    reserve(most + 1, m);
    limbs_[most] = m >= n ? mpn_add(limbs_, limbs_, m, b, n) : mpn_add(limbs_, b, n, limbs_, m);
    normalize(most + 1, is_negative);
  } else if (m > n || (m == n && mpn_cmp(limbs_, b, n) >= 0)) {
    mpn_sub(limbs_, limbs_, m, b, n);
    normalize(m, is_negative);
  } else {
    reserve(n, m);
    mpn_sub(limbs_, b, n, limbs_, m);
    normalize(n, b_is_negative);
  }
  return *this;
}

Number& Number::operator<<=(mp_bitcnt_t bits) {
  const int m = count(), limbs = static_cast<int>(bits / 64), rest = static_cast<int>(bits % 64);
  if (m == 0 || bits == 0) return *this;
  reserve(m + limbs + 1, m);
  limbs_[m + limbs] = 0;
  if (rest != 0)
    limbs_[m + limbs] = mpn_lshift(limbs_ + limbs, limbs_, m, static_cast<unsigned>(rest));
  else
    std::copy_backward(limbs_, limbs_ + m, limbs_ + m + limbs);
  std::fill_n(limbs_, limbs, mp_limb_t{0});
  normalize(m + limbs + 1, size_ < 0);
  return *this;
}

Number& Number::operator>>=(mp_bitcnt_t bits) {
  const int m = count(), rest = static_cast<int>(bits % 64);
  if (bits / 64 >= static_cast<mp_bitcnt_t>(m)) {
    size_ = 0;
    return *this;
  }
  const int limbs = static_cast<int>(bits / 64);
  if (rest != 0)
    mpn_rshift(limbs_, limbs_ + limbs, m - limbs, static_cast<unsigned>(rest));
  else
    std::copy(limbs_ + limbs, limbs_ + m, limbs_);
  normalize(m - limbs, size_ < 0);
  return *this;
}

Number operator*(const Number& a, const Number& b) {
  Number product;
  const int m = a.count(), n = b.count();
  if (m == 0 || n == 0) return product;
  product.reserve(m + n, 0);
  if (m >= n)
    mpn_mul(product.limbs_, a.limbs_, m, b.limbs_, n);
  else
    mpn_mul(product.limbs_, b.limbs_, n, a.limbs_, m);
  product.normalize(m + n, (a.size_ < 0) != (b.size_ < 0));
  return product;
}

void Number::add_product(const Number& a, const Number& b) {
  if (!a.is_zero() && !b.is_zero()) *this += a * b;
}

Number operator/(const Number& a, const Number& b) { return by_gmp(mpz_tdiv_q, a, b); }
Number common_divisor(const Number& a, const Number& b) { return by_gmp(mpz_gcd, a, b); }
Number exact_quotient(const Number& a, const Number& b) { return by_gmp(mpz_divexact, a, b); }

double ratio(const Number& a, const Number& b) {
  int64_t a_exponent = 0, b_exponent = 0;
  const double quotient = a.to_double(a_exponent) / b.to_double(b_exponent);
  return std::ldexp(std::fabs(quotient), static_cast<int>(a_exponent - b_exponent));
}

uint64_t remainder(const Number& a, uint64_t by) {
  mpz_t x;
  return mpz_fdiv_ui(a.view(x), by);
}

}  // namespace collided::exact
