#pragma once
// A point of the way from one position to another. Whoever computes it gets the same bits: clients follow an advance
// without being sent the positions.

#include "gpu/base/groups.hpp"
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

template <class Real>
COLLIDED_HD Vec3<Real> blend(const Vec3<Real>& x, const Vec3<Real>& p, double a) {
  return {blend(x.x, p.x, a), blend(x.y, p.y, a), blend(x.z, p.z, a)};
}

/// The same of all positions.
template <class Real>
struct BlendPositions {
  const Vec3<Real>* from;
  const Vec3<Real>* to;
  double a;
  Vec3<Real>* out;  ///< may be either

  COLLIDED_HD void operator()(uint64_t i) const { out[i] = blend(from[i], to[i], a); }
};

/// The same where vertices have fractions of their own. Those that stand are left as they are in `out`.
template <class Real>
struct BlendEach {
  const Vec3<Real>* from;
  const Vec3<Real>* to;
  const uint32_t* group_of;
  const double* fractions;  ///< by group
  Vec3<Real>* out;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint32_t group = group_of[i];
    if (group != kStands) out[i] = blend(from[i], to[i], fractions[group]);
  }
};

}  // namespace collided
