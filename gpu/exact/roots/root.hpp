#pragma once
// Roots in (0, 1) of integer polynomials as exact numbers, and signs of other polynomials there.

#include <vector>

#include "gpu/exact/form.hpp"

namespace collided::exact {

/// Times of impact are multiples of 2^-kTimeBits, rounded to doubles.
constexpr mp_bitcnt_t kTimeBits = 60;
/// The time of a number in [k, k + 1) / 2^bits, which has kTimeBits bits at least, or is its lower end.
double rounded_time(const Dyadic& at);

/// One real number in (0, 1): a ratio, or the only root of `f` inside a dyadic interval, where it is simple. Refining
/// shortens the interval and leaves the number what it is.
class Root {
 public:
  /// t / (s + t), both above 0.
  static Root at_ratio(Number s, Number t);
  /// The number at the lower end of `at`.
  static Root at_point(const Dyadic& at);
  /// The root of f in the interval `in`; f has the sign `left_sign` between the interval's lower end and the root.
  static Root inside(const Form& f, const Dyadic& in, int left_sign);

  /// Sign of g at this number.
  int sign_of(const Form& g);

  /// False if f is known to be above 0 just before the root.
  bool may_rise() const { return may_rise_; }
  void forget_rise() { may_rise_ = true; }

  /// Rounded down to a multiple of 2^-60 and then to a double: the same for the same number, whatever its polynomial.
  double rounded_down();

 private:
  bool is_ratio() const { return left_sign_ == 0; }
  void refine(mp_bitcnt_t bits);
  void halve();
  bool narrow(mp_bitcnt_t bits);
  bool settle_at(const Dyadic& point, int sign);

  Form f_;
  Dyadic at_;
  Number s_, t_;
  int left_sign_ = 0;  ///< 0: the number is the ratio
  bool may_rise_ = true;
};

/// The distinct roots of f in the open interval (0, 1), ascending. f must not vanish identically.
std::vector<Root> roots_inside(const Form& f);

}  // namespace collided::exact
