#include "gpu/exact/crossings.hpp"

#include "gpu/exact/integers.hpp"

namespace collided {

EdgeTriangleVerdict exact_edge_triangle(const Vec3<double> (&points)[5], const uint32_t (&ids)[5]) {
  EdgeTriangleVerdict verdict;
  exact::with_integers(points, [&](const auto* p) { verdict = exact::fixed::EdgeTriangle(p, ids).verdict(); });
  return verdict;
}

}  // namespace collided
