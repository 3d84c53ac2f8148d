#include "gpu/exact/rough/certain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gpu/exact/roots/places.hpp"

namespace collided::exact {
namespace {

using Place = RoughForm::Place;
using Magnitude = RoughForm::Magnitude;
using Range = RoughForm::Range;

constexpr int kUnknown = RoughForm::kUnknown;

/// An interval of t / s.
struct Interval {
  Place begin, end;
};

bool is_above(const Magnitude& a, const Magnitude& b) {
  if (a.m == 0 || b.m == 0) return a.m > 0;
  int above_a = 0, above_b = 0;
  const double x = std::frexp(a.m, &above_a), y = std::frexp(b.m, &above_b);
  const int64_t i = a.exponent + above_a, j = b.exponent + above_b;
  return i != j ? i > j : x > y;
}
/// `by`: 1, and more than all roundings above it or below it.
Magnitude square(const Magnitude& a, double by) { return {a.m * a.m * by, 2 * a.exponent}; }

int sign_on(const LazyForm& f, const Interval& on) {
  const RoughForm* const rough = f.rough();
  if (rough == nullptr) return kUnknown;
  return rough->vanishes() ? 0 : rough->sign_on(on.begin, on.end);
}
Range range_on(const LazyForm& f, const Interval& on) {
  const RoughForm* const rough = f.rough();
  if (rough == nullptr) return {kUnknown, {}, {1, std::numeric_limits<int64_t>::max() / 4}};
  return rough->range_on(on.begin, on.end);
}
int sign_at(const LazyForm& f, const Place& at) {
  const RoughForm* const rough = f.rough();
  if (rough == nullptr) return kUnknown;
  return rough->vanishes() ? 0 : rough->sign_at(at);
}
/// True if the form is certain to be above 0 at one end and below 0 at the other.
bool changes_sign(const LazyForm& f, const Interval& on) {
  const int first = sign_at(f, on.begin), last = sign_at(f, on.end);
  return (first == 1 && last == -1) || (first == -1 && last == 1);
}

/// Forms of a list, by number, whose signs are in doubt on an interval.
using Doubts = uint32_t;

/// What is in doubt about a case on an interval.
struct Doubtful {
  const Case* c;
  Doubts zero, not_negative, not_zero;
};

/// `crossing`: the component that is not small, if there is one.
bool crosses(const Case& c, const Interval& on, const LazyForm** crossing = nullptr) {
  Magnitude share = range_on(c.limit, on).low;
  share.m *= 0.25;
  bool has_crossed = false;
  for (const LazyForm& f : c.components) {
    if (is_above(share, square(range_on(f, on).high, 1 + 0x1p-50))) continue;
    if (has_crossed || !changes_sign(f, on)) return false;
    has_crossed = true;
    if (crossing != nullptr) *crossing = &f;
  }
  return true;
}

/// False if the contact is certain not to hold at t = 1, where one part of a way ends and the next begins.
bool may_hold_at_end(const Contact& contact) {
  const auto may_hold = [](const Case& c) {
    const auto is_sure = [](const std::vector<LazyForm>& forms, int a, int b) {
      return std::any_of(forms.begin(), forms.end(), [&](const LazyForm& f) {
        const int sign = f.certain_sign_at_end();
        return sign == a || sign == b;
      });
    };
    return !is_sure(c.zero, 1, -1) && !is_sure(c.not_negative, -1, -1) && !is_sure(c.not_zero, 0, 0);
  };
  const int necessary = contact.necessary.certain_sign_at_end();
  return necessary != 1 && necessary != -1 && std::any_of(contact.cases.begin(), contact.cases.end(), may_hold);
}

class Search {
 public:
  /// `cuts`: how often the way has been cut before.
  explicit Search(const Contact& contact, int cuts = 0) : contact_(contact), cuts_(cuts) {
    const auto all = [](const auto& list) { return (Doubts{1} << list.size()) - 1; };
    for (const Case& c : contact.cases) cases_.push_back({&c, all(c.zero), all(c.not_negative), all(c.not_zero)});
  }

  /// kNone: at no time but those left open.
  enum class Outcome : uint8_t { kNone, kFound, kTooMuch };

  Outcome run() { return first_in({{-kFarthest, 1}, {kFarthest, 1}}, all_alternatives(), cases_); }
  double time() const { return time_; }
  const std::vector<Windows::Window>& open() const { return open_; }

 private:
  static constexpr int kMostLooks = 400, kMostCuts = 2;

  /// Looks closer at an interval of which double precision says no more. Where it is too long to have one time, a cut
  /// would not make it shorter.
  Outcome look_closer(const Interval& on, bool has_time) {
    const std::vector<Contact> parts =
        has_time && cuts_ < kMostCuts ? contact_.numbers->cut(on.begin, on.end) : std::vector<Contact>();
    bool is_open = parts.empty();
    for (const Contact& part : parts) {
      if (is_open) break;
      Search search(part, cuts_ + 1);
      const Outcome outcome = search.run();
      is_open = outcome == Outcome::kTooMuch || !search.open_.empty() ||
                (outcome == Outcome::kNone && &part == &parts.front() && may_hold_at_end(part));
      if (!is_open && outcome == Outcome::kFound) {
        time_ = search.time_;
        open_.clear();
        return outcome;
      }
    }
    if (!is_open) {  // the parts are the whole way
      is_over_ = true;
      open_.clear();
    } else if (!open_.empty() && open_.back().second == on.begin) {
      open_.back().second = on.end;
    } else {
      open_.emplace_back(on.begin, on.end);
    }
    return Outcome::kNone;
  }

  Doubts all_alternatives() const { return (Doubts{1} << contact_.alternatives.size()) - 1; }

  Outcome first_in(const Interval& on, Doubts alternatives, std::vector<Doubtful> cases) {
    if (is_over_) return Outcome::kNone;
    if (++looks_ > kMostLooks) return Outcome::kTooMuch;
    if (fails(on, alternatives) || is_never_zero(on)) return Outcome::kNone;
    std::erase_if(cases, [&](Doubtful& c) { return fails(on, c); });
    if (cases.empty()) return Outcome::kNone;
    const Place first = open_.empty() ? on.begin : open_.front().first;
    const std::optional<double> time =
        rounded_time(contact_.numbers->ratio_at(first), contact_.numbers->ratio_at(on.end));
    if (time)
      if (std::any_of(cases.begin(), cases.end(), [&](const Doubtful& c) { return holds_somewhere(on, c); })) {
        time_ = *time;
        open_.clear();
        return Outcome::kFound;
      }
    if (is_short(on.begin, on.end, 0x1p-42)) return look_closer(on, time.has_value());
    const Place middle = between(on.begin, on.end);
    const Outcome outcome = first_in({on.begin, middle}, alternatives, cases);
    return outcome == Outcome::kNone ? first_in({middle, on.end}, alternatives, std::move(cases)) : outcome;
  }

  bool is_never_zero(const Interval& on) const {
    const int sign = sign_on(contact_.necessary, on);
    return sign == 1 || sign == -1;
  }
  /// True if all forms of a list are below 0.
  bool fails(const Interval& on, Doubts& alternatives) const {
    for (size_t i = 0; i < contact_.alternatives.size(); ++i) {
      if ((alternatives >> i & 1) == 0) continue;
      bool may_hold = false;
      for (const LazyForm& f : contact_.alternatives[i]) {
        const int sign = sign_on(f, on);
        if (sign == -1) continue;
        may_hold = true;
        if (sign != kUnknown) alternatives &= ~(Doubts{1} << i);
        break;
      }
      if (!may_hold) return true;
    }
    return false;
  }
  /// True if one of the forms in doubt is certain to have a sign that fails; those are dropped that have another one.
  template <class Fails>
  static bool one_fails(const Interval& on, const std::vector<LazyForm>& forms, Doubts& doubts, const Fails& fails) {
    for (size_t i = 0; i < forms.size(); ++i) {
      if ((doubts >> i & 1) == 0) continue;
      const int sign = sign_on(forms[i], on);
      if (sign == kUnknown) continue;
      if (fails(sign)) return true;
      doubts &= ~(Doubts{1} << i);
    }
    return false;
  }
  static bool fails(const Interval& on, Doubtful& c) {
    return one_fails(on, c.c->zero, c.zero, [](int sign) { return sign != 0; }) ||
           one_fails(on, c.c->not_negative, c.not_negative, [](int sign) { return sign < 0; }) ||
           one_fails(on, c.c->not_zero, c.not_zero, [](int sign) { return sign == 0; }) || is_far(on, c);
  }
  /// True if a component alone is certain to be above the limit.
  static bool is_far(const Interval& on, Doubtful& c) {
    if (c.c->components.empty() || (c.not_negative >> (c.c->not_negative.size() - 1) & 1) == 0) return false;
    const Range limit = range_on(c.c->limit, on);
    for (const LazyForm& f : c.c->components)
      if (is_above(square(range_on(f, on).low, 1 - 0x1p-50), limit.high)) return true;
    return false;
  }

  /// True if the case is certain to hold at a time of the interval. It does at its end if all signs are certain there.
  /// Else one sum of squares may be in doubt, or the form that has to be 0: if one component alone may be large, and
  /// crosses 0, the sum is small when it does.
  bool holds_somewhere(const Interval& on, const Doubtful& c) const {
    if (c.zero != 0) return false;
    const Doubts near = c.c->components.empty() ? 0 : Doubts{1} << (c.c->not_negative.size() - 1);
    const bool may_cross = is_zero(contact_.necessary);
    if ((c.not_negative & ~near) == 0 && c.not_zero == 0)
      if (may_cross ? c.not_negative == 0 || crosses(*c.c, on)
                    : c.not_negative == 0 && changes_sign(contact_.necessary, on))
        return true;
    return may_cross && holds_at(on.end, c);
  }
  static bool is_zero(const LazyForm& f) {
    const RoughForm* const rough = f.rough();
    return rough != nullptr && rough->vanishes();
  }
  static bool holds_at(const Place& at, const Doubtful& c) {
    const auto is_sure = [&](const std::vector<LazyForm>& forms, Doubts doubts, bool may_be_below) {
      for (size_t i = 0; i < forms.size(); ++i) {
        if ((doubts >> i & 1) == 0) continue;
        const int sign = sign_at(forms[i], at);
        if (sign != 1 && !(may_be_below && sign == -1)) return false;
      }
      return true;
    };
    return is_sure(c.c->not_negative, c.not_negative, false) && is_sure(c.c->not_zero, c.not_zero, true);
  }

  const Contact& contact_;
  std::vector<Doubtful> cases_;
  const int cuts_;
  int looks_ = 0;
  bool is_over_ = false;  ///< there is no contact but at times left open
  std::vector<Windows::Window> open_;
  double time_ = 0;
};

}  // namespace

std::optional<CertainImpact> certain_impact(const Contact& contact) {
  Search search(contact);
  const Search::Outcome outcome = search.run();
  if (outcome == Search::Outcome::kTooMuch) return std::nullopt;
  CertainImpact impact{outcome == Search::Outcome::kFound ? search.time() : kNever, search.open(), {}};
  if (!impact.open.empty())
    impact.time_of_open = rounded_time(ratio_of(impact.open.front().first), ratio_of(impact.open.back().second));
  return impact;
}

const LazyForm* crossing_component(const Case& c, const Windows::Window& on) {
  const LazyForm* crossing = nullptr;
  return !c.components.empty() && crosses(c, {on.first, on.second}, &crossing) ? crossing : nullptr;
}

}  // namespace collided::exact
