#include "gpu/exact/windows.hpp"

#include <algorithm>

#include "gpu/exact/roots/places.hpp"

namespace collided::exact {
namespace {

using Place = RoughForm::Place;

constexpr double kShort = 0x1p-4;

}  // namespace

Windows::Windows() : windows_{{{-kFarthest, 1}, {kFarthest, 1}}} {}

template <class IsOut>
void Windows::leave_out(const LazyForm& f, const IsOut& is_out) {
  constexpr size_t kMost = 64;
  const RoughForm* const rough = f.rough();
  if (rough == nullptr || rough->vanishes() || windows_.size() > kMost) return;
  std::vector<Window> left, right_to_left(windows_.rbegin(), windows_.rend());
  while (!right_to_left.empty()) {
    const auto [begin, end] = right_to_left.back();
    right_to_left.pop_back();
    const int sign = rough->sign_on(begin, end);
    if (sign == RoughForm::kUnknown && !is_short(begin, end, kShort)) {
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

void Windows::need_not_negative(const LazyForm& f) {
  leave_out(f, [](int sign) { return sign < 0; });
}
void Windows::need_zero(const LazyForm& f) {
  leave_out(f, [](int sign) { return sign != 0; });
}

void Windows::need(const Case& c) {
  for (const LazyForm& f : c.zero) need_zero(f);
  for (const LazyForm& f : c.not_negative)
    if (!are_empty()) need_not_negative(f);
}

void Windows::need_one_not_negative(const std::vector<LazyForm>& forms) {
  std::vector<Window> all;
  for (const LazyForm& f : forms) {
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

bool Windows::are_above(const LazyForm& f) const {
  const RoughForm* const rough = f.rough();
  return rough != nullptr && std::all_of(windows_.begin(), windows_.end(),
                                         [&](const Window& w) { return rough->sign_on(w.first, w.second) == 1; });
}

}  // namespace collided::exact
