#include "gpu/exact/rough/lazy_form.hpp"

#include <algorithm>

namespace collided::exact {

int LazyForm::sign_at_start() const {
  return degree_ >= 0 && sign_.front() != kUnknown ? sign_.front() : sgn(exact().c.front());
}

int LazyForm::sign_at_end() const {
  const int sign = certain_sign_at_end();
  return sign != kUnknown ? sign : sgn(exact().c.back());
}

bool LazyForm::vanishes() const {
  if (degree_ < 0) return exact().vanishes();
  const auto end = sign_.begin() + degree_ + 1;
  if (std::any_of(sign_.begin(), end, [](int sign) { return sign == 1 || sign == -1; })) return false;
  return std::all_of(sign_.begin(), end, [](int sign) { return sign == 0; }) || (make_ && exact().vanishes());
}

int LazyForm::closed_sign() const {
  if (degree_ < 0) return exact::closed_sign(exact());
  const auto end = sign_.begin() + degree_ + 1;
  const bool may_rise = std::count(sign_.begin(), end, 1) > 0, may_fall = std::count(sign_.begin(), end, -1) > 0;
  if ((may_rise && may_fall) || sign_.front() == 0 || *(end - 1) == 0) return 0;
  if (std::count(sign_.begin(), end, kUnknown) == 0) return sign_.front();
  return make_ ? exact::closed_sign(exact()) : 0;
}

const RoughForm* LazyForm::rough() const {
  if (!rough_ && exact_ && !has_seen_exact_) {
    rough_ = RoughForm::of(*exact_);
    has_seen_exact_ = true;
  }
  return rough_ ? &*rough_ : nullptr;
}

const Form& LazyForm::exact() const {
  if (!exact_) exact_ = make_();
  return *exact_;
}

}  // namespace collided::exact
