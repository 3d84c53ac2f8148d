#pragma once
// Fractions of integers of any size, and long sums of them.

#include <vector>

#include "gpu/exact/number.hpp"

namespace collided::exact {

/// Not reduced. The divisor is above 0.
struct Fraction {
  Number dividend, divisor{1};
};

inline int compare(const Fraction& a, const Fraction& b) {
  return (a.dividend * b.divisor - b.dividend * a.divisor).sign();
}
inline Fraction operator+(const Fraction& a, const Fraction& b) {
  if (a.divisor == b.divisor) return {a.dividend + b.dividend, a.divisor};
  return {a.dividend * b.divisor + b.dividend * a.divisor, a.divisor * b.divisor};
}

/// Adds terms up in a balanced tree. The divisors' product has as many bits as all of them together, so adding one term
/// at a time would take quadratic time.
class FractionSum {
 public:
  void add(Fraction term) {
    for (uint64_t full = count_++; full & 1; full >>= 1) {
      term = partial_.back() + term;
      partial_.pop_back();
    }
    partial_.push_back(std::move(term));
  }
  Fraction total() const {
    Fraction total;
    for (auto partial = partial_.rbegin(); partial != partial_.rend(); ++partial) total = *partial + total;
    return total;
  }

 private:
  std::vector<Fraction> partial_;  ///< sums of as many terms as the bits of count_ say, most first
  uint64_t count_ = 0;
};

}  // namespace collided::exact
