#pragma once
// A point of the way from one position to another. Whoever computes it gets the same bits: clients follow an advance
// without being sent the positions.

#include "gpu/base/host_device.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// fl(x + fl(a * fl(p - x))), each operation rounded to binary64 (none fused), then to the format of the positions.
/// Both ends are exact: x for a = 0, p for a = 1.
template <class Real>
COLLIDED_HD Real blend(Real x, Real p, double a) {
  if (a == 0) return x;
  if (a == 1) return p;
  const double way = static_cast<double>(p) - static_cast<double>(x);
  const double part = a * way;
  return static_cast<Real>(static_cast<double>(x) + part);
}

/// The same of all positions.
template <class Real>
struct BlendPositions {
  const Vec3<Real>* from;
  const Vec3<Real>* to;
  double a;
  Vec3<Real>* out;  ///< may be either

  COLLIDED_HD void operator()(uint64_t i) const {
    const Vec3<Real> x = from[i], p = to[i];
    out[i] = {blend(x.x, p.x, a), blend(x.y, p.y, a), blend(x.z, p.z, a)};
  }
};

}  // namespace collided
