#pragma once
// Conditions of one number, or of four side by side (four.hpp): formulas that are written with these are the same for
// both.

#include "gpu/base/host_device.hpp"

namespace collided {

/// What comparing numbers gives, and the doubles that they widen to.
template <class Number>
struct NumberTraits {
  using Mask = bool;
  using Double = double;
};
template <class Number>
using Mask = typename NumberTraits<Number>::Mask;
template <class Number>
using DoubleOf = typename NumberTraits<Number>::Double;

COLLIDED_HD inline bool any(bool is) { return is; }
COLLIDED_HD inline bool all(bool is) { return is; }

/// a where the condition holds, else b.
template <class T>
COLLIDED_HD T select(bool is, const T& a, const T& b) {
  return is ? a : b;
}
/// The value, but f() where the condition holds: one number computes it only then.
template <class T, class F>
COLLIDED_HD T replace_where(bool is, const T& value, const F& f) {
  return is ? f() : value;
}

}  // namespace collided
