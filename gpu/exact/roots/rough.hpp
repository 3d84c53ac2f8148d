#pragma once
// Roots of forms, and signs there, in double precision with bounds of all errors. Integers decide what it leaves open.
// Coefficients may have exponents that lie far apart. With x = t / s, a form is a polynomial in x, and it has no root
// where one of its terms outweighs all others together. Exponents alone show these places (Newton's polygon). In the
// remaining ones all terms that matter have the size of doubles.

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "gpu/exact/form.hpp"
#include "gpu/exact/roots/root.hpp"
#include "gpu/exact/rough/polynomial.hpp"

namespace collided::exact {

/// A form's coefficients as c * 2^exponent.
class RoughForm {
 public:
  static constexpr int kMostCoefficients = 7;

  /// None if the form has more coefficients.
  static std::optional<RoughForm> of(const Form& f);
  /// None if a coefficient is not known to 2^-52.
  template <int degree>
  static std::optional<RoughForm> of(const RoughPolynomial<degree>& f) {
    static_assert(degree < kMostCoefficients);
    RoughForm rough;
    rough.degree_ = degree;
    for (size_t i = 0; i <= degree; ++i)
      if (!rough.set(i, f.c[i])) return std::nullopt;
    return rough;
  }
  /// The form without factors s and t. It does not vanish.
  RoughForm without_roots_at_ends() const;

  int degree() const { return degree_; }
  bool vanishes() const;

  /// x = 2^scale y, with y in [1, 2).
  struct Place {
    int64_t scale;
    double y;
    friend bool operator==(const Place& a, const Place& b) = default;
  };
  /// The sign of all of [begin, end]; kUnknown: there may be a root. The form does not vanish.
  int sign_on(const Place& begin, const Place& end) const;

  int sign_at(const Place& at) const;

  /// m * 2^exponent, not negative.
  struct Magnitude {
    double m = 0;
    int64_t exponent = 0;
  };
  /// The sign all over an interval, or kUnknown, and bounds of the magnitude there.
  struct Range {
    int sign;
    Magnitude low, high;
  };
  Range range_on(const Place& begin, const Place& end) const;

  /// Where roots may be: x in [2^(scale - reach), 2^(scale + reach)].
  struct Neighbourhood {
    int64_t scale;
    int reach;
  };
  /// All roots in (0, 1) are in these, ascending. None if one is too long. The first and last coefficient are not 0.
  std::optional<std::vector<Neighbourhood>> neighbourhoods() const;

  /// The coefficients at x = 2^scale y as a polynomial in y, times a power of two.
  class Local {
   public:
    /// The sign at y; kUnknown where rounding may have made it.
    int sign_at(double y) const;
    /// The sign of all of [begin, end]; kUnknown: there may be a root.
    int sign_on(double begin, double end) const;
    /// Bounds of the magnitude over [begin, end]: the lower one is 0 where there may be a root.
    std::pair<double, double> magnitudes_on(double begin, double end, int& sign) const;
    /// Changes of sign along the coefficients over [begin, end], or kUnknown; `first`: the sign at `begin`.
    int changes_on(double begin, double end, int& first) const;

   private:
    friend class RoughForm;
    using Signs = std::array<int, kMostCoefficients>;
    Signs signs_on(double begin, double end) const;
    /// use(j, sum, size) for the coefficients over [begin, end], with their terms' magnitudes.
    template <class Use>
    void for_coefficients_on(double begin, double end, const Use& use) const;

    std::array<double, kMostCoefficients> c_{};
    int degree_ = 0;
    int64_t top_ = 0;  ///< the power of two by which they were divided
  };
  Local at_scale(int64_t scale) const;

  static constexpr int kUnknown = 99;

 private:
  bool set(size_t i, const RoughNumber& c);
  /// The term that outweighs all others together at x = 2^scale; -1: none.
  int largest_term(int64_t scale) const;

  std::array<double, kMostCoefficients> c_{};
  std::array<int64_t, kMostCoefficients> exponent_{};
  int degree_ = 0;
};

/// A time in (0, 1) rounded down as Root::rounded_down has it, given t / s within bounds that are known to 2^-51; none
/// if that is not enough.
std::optional<double> rounded_time(double low, double high);
/// 2^scale y, or a number as far from 1 for times.
double ratio_of(const RoughForm::Place& at);

/// A simple root of a form, which has no other one in its interval.
class RoughRoot {
 public:
  RoughRoot(const RoughForm::Local& f, int64_t scale, double begin, double end, int left_sign)
      : f_(f), scale_(scale), begin_(begin), end_(end), left_sign_(left_sign) {}

  /// Sign of g there, or kUnknown.
  int sign_of(const RoughForm& g);
  /// False if the form is above 0 just before the root.
  bool may_rise() const { return left_sign_ < 0; }
  /// True if it is certain to be between two places.
  bool is_within(const RoughForm::Place& from, const RoughForm::Place& to);
  /// As Root::rounded_down; none where the root is too close to where that begins to be another number.
  std::optional<double> rounded_down();
  /// The root of its form; none if there are others that are not far enough from it.
  std::optional<Root> exact(const Form& f) const;

 private:
  /// Cuts the interval in two so often; false where rounding hides the side of a cut that the root is on.
  bool refine(int times);
  double ratio(double y) const { return ratio_of({scale_, y}); }

  RoughForm::Local f_;
  int64_t scale_;
  double begin_, end_;
  int left_sign_;
};

/// All roots in (0, 1) of a form that does not vanish at 0 or 1, ascending; none if some are too close together.
std::optional<std::vector<RoughRoot>> rough_roots(const RoughForm& f);

}  // namespace collided::exact
