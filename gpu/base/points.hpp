#pragma once
// The four points of a pair of features at both ends of the step: vertex and triangle's corners, or the two edges'
// ends.

#include "gpu/base/vec3.hpp"

namespace collided {

template <class Real>
struct FeaturePoints {
  Vec3<Real> start[4], end[4];
};

}  // namespace collided
