#pragma once
// Forms that become integers only where a decision needs them: signs and roots mostly follow from what double precision
// knows of the coefficients.

#include <array>
#include <functional>
#include <optional>

#include "gpu/exact/form.hpp"
#include "gpu/exact/roots/rough.hpp"
#include "gpu/exact/rough/polynomial.hpp"

namespace collided::exact {

class LazyForm {
 public:
  LazyForm() : LazyForm(Form()) {}
  explicit LazyForm(Form exact) : exact_(std::move(exact)) {}
  /// `make` gives the form that `rough` is near; what it refers to outlives this. Without it there is no exact form,
  /// and the form is what may be.
  template <int degree>
  LazyForm(const RoughPolynomial<degree>& rough, std::function<Form()> make)
      : make_(std::move(make)), degree_(degree), rough_(RoughForm::of(rough)) {
    static_assert(degree < RoughForm::kMostCoefficients);
    for (int i = 0; i <= degree; ++i) sign_[static_cast<size_t>(i)] = sign_of(rough.c[i]);
  }

  /// At t = 0 and at t = 1.
  int sign_at_start() const;
  int sign_at_end() const;
  /// The same as far as rough numbers tell, or RoughForm::kUnknown.
  int certain_sign_at_end() const { return degree_ >= 0 ? sign_[static_cast<size_t>(degree_)] : kUnknown; }
  bool vanishes() const;
  /// As closed_sign of form.hpp.
  int closed_sign() const;
  /// Null where some coefficients are not known well, or there are too many of them.
  const RoughForm* rough() const;
  /// The form, or one with the same signs in [0, 1].
  const Form& exact() const;

 private:
  static constexpr int kUnknown = RoughForm::kUnknown;

  static int sign_of(const RoughNumber& c) {
    if (c.size == 0) return 0;
    const long double error = kCertainShare * c.size;
    return c.value > error ? 1 : c.value < -error ? -1 : kUnknown;
  }

  std::function<Form()> make_;
  int degree_ = -1;  ///< of the rough form; -1: there is none
  std::array<int, RoughForm::kMostCoefficients> sign_{};
  mutable std::optional<RoughForm> rough_;
  mutable bool has_seen_exact_ = false;  ///< the rough form is that of exact_, if there is one
  mutable std::optional<Form> exact_;
};

}  // namespace collided::exact
