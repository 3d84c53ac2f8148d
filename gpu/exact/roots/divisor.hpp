#pragma once
// Greatest common divisors of integer polynomials. A form stands for the polynomial in t / s with its coefficients,
// whose positive roots are the form's roots in (0, 1); roots at the ends may be lost or kept.

#include "gpu/exact/form.hpp"

namespace collided::exact {

/// Greatest common divisor of a and b, but for a constant. At most one of them may vanish.
Form common_divisor(const Form& a, const Form& b);

/// False if a simple look shows that f has no root twice. f must not vanish.
bool may_repeat(const Form& f);

/// The form with the roots of f in (0, 1), each of them once. f must not vanish.
Form square_free(const Form& f);

}  // namespace collided::exact
