#pragma once
// "In contact at time t" as a disjunction of conjunctions of signs of polynomials in t, and its first time.

#include <vector>

#include "gpu/exact/exact.hpp"
#include "gpu/exact/form.hpp"

namespace collided::exact {

/// Holds at t if every form of `zero` is 0, of `not_negative` >= 0, of `not_zero` not 0 there.
struct Case {
  std::vector<Form> zero;
  std::vector<Form> not_negative;
  std::vector<Form> not_zero;
  std::vector<Form> implied;  ///< >= 0 wherever the case holds: what is easier to look at than the others
};

/// Holds at t if one of the cases does. All cases together hold on a closed set of times; one alone need not, because
/// of `not_zero`.
struct Contact {
  Form necessary;  ///< 0 at every time of contact; the zero form if nothing simple is known
  std::vector<Case> cases;
  /// At every time of contact one form of each list at least is >= 0.
  std::vector<std::vector<Form>> alternatives = {};
};

/// True if the alternatives alone show that there is no contact in [0, 1].
bool alternatives_exclude(const Contact& contact);

/// The contact holds at t = 0; forms of degree 0 will do.
bool holds_at_start(const Contact& contact);

/// The first time in [0, 1].
ExactImpact first_impact(const Contact& contact);

}  // namespace collided::exact
