#include "gpu/exact/roots/located.hpp"

#include "gpu/exact/roots/divisor.hpp"

namespace collided::exact {

LocatedRoots::LocatedRoots(const Form& f) : f_(without_roots_at_ends(f)), rough_(rough_roots(f_)) {
  if (rough_ || !may_repeat(f_)) return;
  f_ = square_free(f_);
  is_simplified_ = true;
  rough_ = rough_roots(f_);
}

int LocatedRoots::sign_of(size_t i, const Form& g) {
  const int sign = rough_ ? (*rough_)[i].sign_of(g) : RoughForm::kUnknown;
  return sign != RoughForm::kUnknown ? sign : exact()[i].sign_of(g);
}

double LocatedRoots::rounded_down(size_t i) {
  if (rough_)
    if (const std::optional<double> time = (*rough_)[i].rounded_down(f_)) return *time;
  return exact()[i].rounded_down();
}

std::vector<Root>& LocatedRoots::exact() {
  if (!exact_) exact_ = roots_inside(f_);
  return *exact_;
}

}  // namespace collided::exact
