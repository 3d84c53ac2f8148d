#pragma once
// The formats that positions come in.

#include <limits>
#include <string>

#include "gpu/types.hpp"

namespace collided {

/// use(Real{}) with the type that the engine computes in.
template <class Use>
auto with_real(Scalar scalar, const Use& use) {
  return scalar == Scalar::kF64 ? use(double{}) : use(float{});
}

inline std::string name_of(Scalar scalar) { return scalar == Scalar::kF64 ? "F64" : "F32"; }

/// Largest magnitude of a coordinate: an eighth of the largest number, so that sums and differences stay finite.
inline double coordinate_limit(Scalar scalar) {
  return with_real(scalar, []<class Real>(Real) { return double{std::numeric_limits<Real>::max() / 8}; });
}

}  // namespace collided
