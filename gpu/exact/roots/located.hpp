#pragma once
// The roots of a form in (0, 1) and other forms' signs there: in double precision (rough.hpp) as far as that decides,
// else exactly (root.hpp).

#include <optional>
#include <vector>

#include "gpu/exact/roots/root.hpp"
#include "gpu/exact/roots/rough.hpp"
#include "gpu/exact/rough/lazy_form.hpp"

namespace collided::exact {

/// Ascending and distinct.
class LocatedRoots {
 public:
  /// f must not vanish, and outlives this.
  explicit LocatedRoots(const LazyForm& f);

  size_t size() { return rough_ ? rough_->size() : exact().size(); }
  /// False if the form is known to be above 0 just before the root.
  bool may_rise(size_t i) { return is_simplified_ || (rough_ ? (*rough_)[i].may_rise() : exact()[i].may_rise()); }
  /// True if the root is certain to be between two places.
  bool is_within(size_t i, const std::pair<RoughForm::Place, RoughForm::Place>& on);
  int sign_of(size_t i, const LazyForm& g);
  /// As Root::rounded_down.
  double rounded_down(size_t i);

 private:
  const Form& exact_form();
  std::vector<Root>& exact();
  Root& exact(size_t i);

  const LazyForm& source_;
  std::optional<Form> f_;       ///< without roots at the ends
  bool is_simplified_ = false;  ///< each root was left once; the form has other signs between them
  std::optional<std::vector<RoughRoot>> rough_;
  std::optional<std::vector<Root>> exact_;
  std::vector<std::optional<Root>> exact_from_rough_;
};

}  // namespace collided::exact
