#include "gpu/exact/rays.hpp"

#include "gpu/exact/integers.hpp"

namespace collided {

RayVerdict exact_ray(const Vec3<double> (&points)[4], const uint32_t (&ids)[4]) {
  RayVerdict verdict;
  exact::with_integers(points, [&](const auto* p) { verdict = exact::fixed::RayTriangle(p, ids).verdict(); });
  return verdict;
}

}  // namespace collided
