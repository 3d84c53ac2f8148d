#include "gpu/exact/contact.hpp"

#include <algorithm>
#include <optional>
#include <span>

#include "gpu/exact/roots/located.hpp"
#include "gpu/exact/rough/certain.hpp"
#include "gpu/exact/windows.hpp"

namespace collided::exact {
namespace {

/// `sign` gives a form's sign at the time in question.
template <class Sign>
bool holds(const Case& c, Sign sign) {
  return std::all_of(c.zero.begin(), c.zero.end(), [&](const LazyForm& f) { return sign(f) == 0; }) &&
         std::all_of(c.not_zero.begin(), c.not_zero.end(), [&](const LazyForm& f) { return sign(f) != 0; }) &&
         std::all_of(c.not_negative.begin(), c.not_negative.end(), [&](const LazyForm& f) { return sign(f) >= 0; });
}

template <class Sign>
bool any_holds(std::span<const Case> cases, Sign sign) {
  return std::any_of(cases.begin(), cases.end(), [&](const Case& c) { return holds(c, sign); });
}

/// The first root of `source` in (0, 1) where one of the cases holds, rounded down; kNever if there is none. `rising`:
/// only those count before which the form is below 0.
double first_root(const LazyForm& source, std::span<const Case> cases, bool rising) {
  LocatedRoots roots(source);
  for (size_t i = 0; i < roots.size(); ++i) {
    if (rising && !roots.may_rise(i)) continue;
    const auto sign = [&](const LazyForm& f) { return &f == &source ? 0 : roots.sign_of(i, f); };
    if (any_holds(cases, sign)) return roots.rounded_down(i);
  }
  return kNever;
}

/// At the roots of the forms one of which has a root at the case's first time; see first_impact.
double first_root(const Case& c, Windows windows) {
  windows.need(c);
  if (windows.are_empty()) return kNever;
  for (const LazyForm& f : c.zero)
    if (!f.vanishes()) return first_root(f, {&c, 1}, false);
  double first = kNever;
  for (const LazyForm& f : c.not_negative)
    if (!f.vanishes() && !windows.are_above(f)) first = std::min(first, first_root(f, {&c, 1}, true));
  return first;
}

/// At the roots of a form that is 0 whenever one of the cases holds.
double first_root(const LazyForm& necessary, std::span<const Case> cases, Windows windows) {
  windows.need_zero(necessary);
  const bool may_hold = std::any_of(cases.begin(), cases.end(), [&](const Case& c) {
    Windows left = windows;
    left.need(c);
    return !left.are_empty();
  });
  return may_hold ? first_root(necessary, cases, false) : kNever;
}

/// True if the case holds at a time between two places at which a component crosses 0.
bool holds_at_crossing(const Case& c, const Windows::Window& on) {
  const LazyForm* const component = crossing_component(c, on);
  if (component == nullptr) return false;
  LocatedRoots roots(*component);
  for (size_t i = 0; i < roots.size(); ++i) {
    const auto sign = [&](const LazyForm& f) { return &f == &c.not_negative.back() ? 1 : roots.sign_of(i, f); };
    if (roots.is_within(i, on) && holds(c, sign)) return true;
  }
  return false;
}
bool holds_at_crossing(const Contact& contact, const std::vector<Windows::Window>& windows) {
  return std::any_of(windows.begin(), windows.end(), [&](const Windows::Window& on) {
    return std::any_of(contact.cases.begin(), contact.cases.end(),
                       [&](const Case& c) { return holds_at_crossing(c, on); });
  });
}

Windows windows_of_alternatives(const Contact& contact) {
  Windows windows;
  for (const std::vector<LazyForm>& forms : contact.alternatives)
    if (!windows.are_empty()) windows.need_one_not_negative(forms);
  return windows;
}

}  // namespace

bool holds_at_start(const Contact& contact) {
  const auto sign = [](const LazyForm& f) { return f.sign_at_start(); };
  return sign(contact.necessary) == 0 && any_holds(contact.cases, sign);
}

bool holds_at_end(const Contact& contact) {
  const auto sign = [](const LazyForm& f) { return f.sign_at_end(); };
  return sign(contact.necessary) == 0 && any_holds(contact.cases, sign);
}

// No time between the roots has to be tried. The set of contact is closed, so it has a first time T, and some case C
// holds at T. If a form of C's `zero` does not vanish identically, T is one of its roots. If all of them do, T is 0 or
// a root of a form of C's `not_negative` that is below 0 a little before T: else C would hold there, too (what is not 0
// stays so), and T would not be the first. Roots of `not_zero` need not be tried, as C fails there. Every root that
// passes is a time of contact, so the first of them is T; the least of their rounded times is T's, as rounding is
// monotone.
ExactImpact first_impact(const Contact& contact) {
  if (holds_at_start(contact)) return {true, 0, true};
  std::optional<CertainImpact> certain;
  if (contact.numbers != nullptr) certain = certain_impact(contact);
  if (certain && certain->time_of_open && holds_at_crossing(contact, certain->open))
    return {true, *certain->time_of_open, false};
  double first = certain ? certain->time : kNever;
  const Windows windows = certain ? Windows(std::move(certain->open)) : windows_of_alternatives(contact);
  if (windows.are_empty()) {
  } else if (!contact.necessary.vanishes()) {
    first = std::min(first, first_root(contact.necessary, contact.cases, windows));
  } else {
    for (const Case& c : contact.cases) first = std::min(first, first_root(c, windows));
  }
  if (first < kNever) return {true, first, false};
  if (holds_at_end(contact)) return {true, 1, false};
  return {};
}

}  // namespace collided::exact
