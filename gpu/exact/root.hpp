#pragma once
// Roots in (0, 1) of integer polynomials as exact numbers, and signs of other polynomials there.

#include <vector>

#include "gpu/exact/form.hpp"

namespace collided::exact {

/// One real number in (0, 1): a dyadic number, or the only root of `f` inside a dyadic interval, where it is simple.
/// Refining shortens the interval and leaves the number what it is.
class Root {
 public:
  /// The number at the lower end of `at`.
  static Root at_point(const Dyadic& at);
  /// The root of f in the interval `in`; f has the sign `left_sign` between the interval's lower end and the root.
  static Root inside(const Form& f, const Dyadic& in, int left_sign);

  /// Sign of g at this number.
  int sign_of(const Form& g);

  /// Rounded down to a multiple of 2^-60 and then to a double: the same for the same number, whatever its polynomial.
  double rounded_down();

 private:
  void refine(mp_bitcnt_t bits);
  void halve();
  bool narrow(mp_bitcnt_t bits);
  bool settle_at(const Dyadic& point, int sign);

  Form f_;
  Dyadic at_;
  int left_sign_ = 0;  ///< 0: the number is the point itself
};

/// The distinct roots of f in the open interval (0, 1), ascending. f must not vanish identically.
std::vector<Root> roots_inside(const Form& f);

}  // namespace collided::exact
