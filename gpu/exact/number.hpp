#pragma once
// Integers of any size. Numbers of up to kInline limbs, which ordinary decisions need, allocate nothing: half of the
// time of such a decision went to malloc and free.

#include <gmp.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

namespace collided::exact {

class Number {
 public:
  Number() = default;
  Number(int64_t x) : size_(x > 0 ? 1 : x < 0 ? -1 : 0) {  // NOLINT: as an int converts to a double
    inline_[0] = x < 0 ? ~static_cast<uint64_t>(x) + 1 : static_cast<uint64_t>(x);
  }
  /// Copies a GMP integer.
  static Number of(mpz_srcptr x) {
    Number n;
    n.assign(mpz_limbs_read(x), x->_mp_size);
    return n;
  }
  /// Copies limbs, the lowest first.
  static Number of(const uint64_t* limbs, int count, bool is_negative) {
    Number n;
    n.assign_limbs(limbs, count, is_negative);
    return n;
  }
  Number(const Number& other) { assign(other.limbs_, other.size_); }
  Number(Number&& other) noexcept { take(other); }
  Number& operator=(const Number& other) {
    if (this != &other) assign(other.limbs_, other.size_);
    return *this;
  }
  Number& operator=(Number&& other) noexcept {
    if (this == &other) return *this;
    release();
    take(other);
    return *this;
  }
  ~Number() { release(); }

  int sign() const { return size_ < 0 ? -1 : size_ > 0 ? 1 : 0; }
  bool is_zero() const { return size_ == 0; }
  bool is_negative() const { return size_ < 0; }
  /// Bits of the magnitude; 0 of 0.
  mp_bitcnt_t bits() const { return is_zero() ? 0 : mpn_sizeinbase(limbs_, count(), 2); }
  /// The power of two that divides it; it is not 0.
  mp_bitcnt_t trailing_zeros() const { return mpn_scan1(limbs_, 0); }
  /// A GMP integer that lives as long as this one stays as it is.
  mpz_srcptr view(mpz_t out) const { return mpz_roinit_n(out, limbs_, size_); }
  /// Rounded toward 0.
  double to_double() const;
  /// The same, but for the factor 2^exponent: of magnitude 1/2 to 1, or 0.
  double to_double(int64_t& exponent) const;

  void negate() { size_ = -size_; }
  Number& operator+=(const Number& b) { return this == &b ? *this <<= 1 : add(b.limbs_, b.size_); }
  Number& operator-=(const Number& b) { return this == &b ? *this = Number() : add(b.limbs_, -b.size_); }
  Number& operator<<=(mp_bitcnt_t bits);
  /// Rounds toward 0.
  Number& operator>>=(mp_bitcnt_t bits);
  /// Adds a b.
  void add_product(const Number& a, const Number& b);

  friend Number operator*(const Number& a, const Number& b);
  friend Number operator/(const Number& a, const Number& b);  ///< rounds toward 0
  friend bool operator==(const Number& a, const Number& b) {
    return a.size_ == b.size_ && std::equal(a.limbs_, a.limbs_ + a.count(), b.limbs_);
  }

 private:
  static constexpr int kInline = 14;  ///< six coordinates of two limbs

  int count() const { return size_ < 0 ? -size_ : size_; }
  void release() {
    if (limbs_ != inline_) std::allocator<mp_limb_t>().deallocate(limbs_, static_cast<size_t>(capacity_));
  }
  void take(Number& other) {
    size_ = other.size_;
    if (other.limbs_ == other.inline_) {
      limbs_ = inline_;
      capacity_ = kInline;
      std::copy_n(other.inline_, count(), inline_);
    } else {
      limbs_ = std::exchange(other.limbs_, other.inline_);
      capacity_ = std::exchange(other.capacity_, kInline);
    }
    other.size_ = 0;
  }
  /// Makes room for `limbs`, whose first `kept` stay.
  void reserve(int limbs, int kept);
  void assign(const mp_limb_t* from, int size);
  void assign_limbs(const uint64_t* from, int limbs, bool is_negative) {
    reserve(limbs, 0);
    std::copy_n(from, limbs, limbs_);
    normalize(limbs, is_negative);
  }
  Number& add(const mp_limb_t* b, int size);
  /// Drops leading zeros of `limbs`, and sets the sign.
  void normalize(int limbs, bool is_negative) {
    while (limbs > 0 && limbs_[limbs - 1] == 0) --limbs;
    size_ = is_negative ? -limbs : limbs;
  }

  mp_limb_t* limbs_ = inline_;
  int size_ = 0, capacity_ = kInline;  ///< of limbs; a negative number's size is negative
  mp_limb_t inline_[kInline];
};

/// Greatest common divisor, not negative.
Number common_divisor(const Number& a, const Number& b);
/// a / b, where b divides a.
Number exact_quotient(const Number& a, const Number& b);
/// Returns |a| / |b|, where |a| <= |b|, both rounded toward 0 to 53 bits.
double ratio(const Number& a, const Number& b);
/// The number in [0, by) that differs from a by a multiple of `by`.
uint64_t remainder(const Number& a, uint64_t by);

inline int sgn(const Number& a) { return a.sign(); }
inline Number operator+(Number a, const Number& b) { return std::move(a += b); }
inline Number operator-(Number a, const Number& b) { return std::move(a -= b); }
inline Number operator-(Number a) {
  a.negate();
  return a;
}
inline Number operator<<(Number a, mp_bitcnt_t bits) { return std::move(a <<= bits); }
inline Number operator>>(Number a, mp_bitcnt_t bits) { return std::move(a >>= bits); }

}  // namespace collided::exact
