#include "gpu/exact/roots/located.hpp"

#include "gpu/exact/roots/divisor.hpp"

namespace collided::exact {

LocatedRoots::LocatedRoots(const LazyForm& f) : source_(f) {
  if (const RoughForm* rough = f.rough()) rough_ = rough_roots(rough->without_roots_at_ends());
  if (rough_ || !may_repeat(exact_form())) return;
  f_ = square_free(*f_);
  is_simplified_ = true;
  if (const std::optional<RoughForm> rough = RoughForm::of(*f_)) rough_ = rough_roots(*rough);
}

int LocatedRoots::sign_of(size_t i, const LazyForm& g) {
  const RoughForm* const rough = rough_ ? g.rough() : nullptr;
  const int sign = rough != nullptr ? (*rough_)[i].sign_of(*rough) : RoughForm::kUnknown;
  return sign != RoughForm::kUnknown ? sign : exact(i).sign_of(g.exact());
}

bool LocatedRoots::is_within(size_t i, const std::pair<RoughForm::Place, RoughForm::Place>& on) {
  return rough_ && (*rough_)[i].is_within(on.first, on.second);
}

double LocatedRoots::rounded_down(size_t i) {
  if (rough_) {
    if (const std::optional<double> time = (*rough_)[i].rounded_down()) return *time;
    if (std::optional<Root> root = (*rough_)[i].exact(exact_form())) return root->rounded_down();
  }
  return exact()[i].rounded_down();
}

const Form& LocatedRoots::exact_form() {
  if (!f_) f_ = without_roots_at_ends(source_.exact());
  return *f_;
}

std::vector<Root>& LocatedRoots::exact() {
  if (!exact_) exact_ = roots_inside(exact_form());
  return *exact_;
}

// Isolating all roots is faster where the coefficients are small. Where they are large, one root is refined from its
// rough interval, which is short and so has short numbers.
Root& LocatedRoots::exact(size_t i) {
  constexpr mp_bitcnt_t kLarge = 2000;
  if (exact_ || !rough_ || exact_form().c.front().bits() < kLarge) return exact()[i];
  exact_from_rough_.resize(rough_->size());
  std::optional<Root>& root = exact_from_rough_[i];
  if (!root) root = (*rough_)[i].exact(exact_form());
  return root ? *root : exact()[i];
}

}  // namespace collided::exact
