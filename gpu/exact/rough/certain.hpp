#pragma once
// The first time of contact, where double precision is sure of it: of what a contact is made of, most has a sign that
// is certain at all times but a few.

#include <optional>
#include <vector>

#include "gpu/exact/contact.hpp"
#include "gpu/exact/windows.hpp"

namespace collided::exact {

struct CertainImpact {
  /// The first time that is certain to be one of contact: kNever if there is none in (0, 1).
  double time;
  /// Intervals before it in which there may be others.
  std::vector<Windows::Window> open;
  /// The time of all that is left open, where it is the same.
  std::optional<double> time_of_open;
};
constexpr double kNever = 2;

/// A component of the case's sum of squares that crosses 0 between two places, where the others are certain to be
/// small: the sum is within the limit when it does. Null if that is in doubt.
const LazyForm* crossing_component(const Case& c, const Windows::Window& on);

/// Of a contact that does not hold at t = 0. None if too much is in doubt.
std::optional<CertainImpact> certain_impact(const Contact& contact);

}  // namespace collided::exact
