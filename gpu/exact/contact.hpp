#pragma once
// "In contact at time t" as a disjunction of conjunctions of signs of polynomials in t, and its first time.

#include <memory>
#include <vector>

#include "gpu/exact/exact.hpp"
#include "gpu/exact/rough/lazy_form.hpp"

namespace collided::exact {

/// Holds at t if every form of `zero` is 0, of `not_negative` >= 0, of `not_zero` not 0 there.
struct Case {
  std::vector<LazyForm> zero;
  std::vector<LazyForm> not_negative;
  std::vector<LazyForm> not_zero;
  /// If there are any, the last form of `not_negative` is the limit minus the sum of their squares.
  std::vector<LazyForm> components;
  LazyForm limit;
};

struct Contact;

/// What a contact's forms are made of when they are, where exponents may lie far apart.
class Numbers {
 public:
  Numbers() = default;
  Numbers(const Numbers&) = delete;
  Numbers& operator=(const Numbers&) = delete;
  virtual ~Numbers() = default;

  /// t / s of the whole way, at a place of the part of it that the contact is about.
  virtual double ratio_at(const RoughForm::Place& place) const = 0;
  /// The same contact on both parts of the way, cut between two places, as far as double precision tells; or nothing.
  virtual std::vector<Contact> cut(const RoughForm::Place& from, const RoughForm::Place& to) const = 0;
};

/// Holds at t if one of the cases does. All cases together hold on a closed set of times; one alone need not, because
/// of `not_zero`.
struct Contact {
  LazyForm necessary;  ///< 0 at every time of contact; the zero form if nothing simple is known
  std::vector<Case> cases;
  /// At every time of contact one form of each list at least is >= 0.
  std::vector<std::vector<LazyForm>> alternatives = {};
  std::shared_ptr<const Numbers> numbers = nullptr;  ///< null where they fit integers of fixed size
};

/// The contact holds at t = 0; forms of degree 0 will do.
bool holds_at_start(const Contact& contact);
/// The same at t = 1.
bool holds_at_end(const Contact& contact);

/// The first time in [0, 1].
ExactImpact first_impact(const Contact& contact);

}  // namespace collided::exact
