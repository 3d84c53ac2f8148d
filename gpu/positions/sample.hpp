#pragma once
// Some of a scene's positions, brought together.

#include "gpu/base/vec3.hpp"

namespace collided {

/// Every `stride`-th position.
template <class Real>
struct SamplePositions {
  const Vec3<Real>* positions;
  uint64_t stride;
  Vec3<Real>* sample;

  COLLIDED_HD void operator()(uint64_t i) const { sample[i] = positions[i * stride]; }
};

}  // namespace collided
