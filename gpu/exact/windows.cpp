#include "gpu/exact/windows.hpp"

#include <algorithm>

namespace collided::exact {
namespace {

using Place = RoughForm::Place;

/// Above all exponents of coefficients: beyond it forms keep their signs.
constexpr int64_t kFarthest = 40000;

/// Between two places: halfway in the exponent, or of two in one binary order or in neighbouring ones, in the middle.
Place between(const Place& a, const Place& b) {
  if (b.scale - a.scale > 1) return {a.scale + (b.scale - a.scale) / 2, 1.015625};
  const double last = b.scale == a.scale ? b.y : 2 * b.y, middle = a.y + (last - a.y) * 0.4921875;
  return middle < 2 ? Place{a.scale, middle} : Place{a.scale + 1, middle / 2};
}

bool is_short(const Place& a, const Place& b) {
  constexpr double kShort = 0x1p-4;
  const int64_t scales = b.scale - a.scale;
  return scales == 0 ? b.y - a.y < kShort : scales == 1 && 2 * b.y - a.y < kShort;
}

}  // namespace

Windows::Windows() : windows_{{{-kFarthest, 1}, {kFarthest, 1}}} {}

template <class IsOut>
void Windows::leave_out(const Form& f, const IsOut& is_out) {
  constexpr size_t kMost = 64;
  const std::optional<RoughForm> rough = RoughForm::of(f);
  if (!rough || windows_.size() > kMost) return;
  std::vector<Window> left, right_to_left(windows_.rbegin(), windows_.rend());
  while (!right_to_left.empty()) {
    const auto [begin, end] = right_to_left.back();
    right_to_left.pop_back();
    const int sign = rough->sign_on(begin, end);
    if (sign == RoughForm::kUnknown && !is_short(begin, end)) {
      const Place middle = between(begin, end);
      right_to_left.push_back({middle, end});
      right_to_left.push_back({begin, middle});
    } else if (sign == RoughForm::kUnknown || !is_out(sign)) {
      if (!left.empty() && left.back().second == begin)
        left.back().second = end;
      else
        left.push_back({begin, end});
    }
  }
  windows_ = std::move(left);
}

void Windows::need_not_negative(const Form& f) {
  if (!f.vanishes()) leave_out(f, [](int sign) { return sign < 0; });
}
void Windows::need_zero(const Form& f) {
  if (!f.vanishes()) leave_out(f, [](int sign) { return sign != 0; });
}

void Windows::need(const Case& c) {
  for (const Form& f : c.zero) need_zero(f);
  for (const auto* forms : {&c.implied, &c.not_negative})
    for (const Form& f : *forms)
      if (!are_empty()) need_not_negative(f);
}

void Windows::need_one_not_negative(const std::vector<Form>& forms) {
  std::vector<Window> all;
  for (const Form& f : forms) {
    Windows left = *this;
    left.need_not_negative(f);
    all.insert(all.end(), left.windows_.begin(), left.windows_.end());
  }
  const auto is_before = [](const Place& a, const Place& b) {
    return a.scale != b.scale ? a.scale < b.scale : a.y < b.y;
  };
  std::sort(all.begin(), all.end(), [&](const Window& a, const Window& b) { return is_before(a.first, b.first); });
  windows_.clear();
  for (const Window& w : all) {
    if (windows_.empty() || is_before(windows_.back().second, w.first))
      windows_.push_back(w);
    else if (is_before(windows_.back().second, w.second))
      windows_.back().second = w.second;
  }
}

bool Windows::are_above(const Form& f) const {
  const std::optional<RoughForm> rough = RoughForm::of(f);
  return rough && std::all_of(windows_.begin(), windows_.end(), [&](const Window& w) {
           return rough->sign_on(w.first, w.second) == 1;
         });
}

}  // namespace collided::exact
