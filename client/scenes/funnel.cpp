// Scene funnel: a square cloth is drawn through a cone and a tube, folding as it narrows.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

namespace {

constexpr double kHalf = 2, kRim = 1.6, kTube = 0.22, kHeight = 1.4, kTubeLength = 1.2;
const double kSlope = std::hypot(kRim - kTube, kHeight);

/// Radius and height of the profile rim - cone - tube, `sigma` along it from the rim's inner edge.
std::array<double, 2> profile(double sigma) {
  if (sigma <= 0) return {kRim - sigma, 0};
  if (sigma >= kSlope) return {kTube, -kHeight - (sigma - kSlope)};
  return {kRim - (kRim - kTube) * sigma / kSlope, -kHeight * sigma / kSlope};
}

Vec3d cloth(Param pq, double t) {
  const auto [p, q] = pq;
  const double s = std::hypot(p, q), angle = std::atan2(q, p);
  const double centre = -kRim + 0.1 + (kSlope + kRim + 3.2) * t;
  auto [r, z] = centre <= 0 ? std::array{s, 0.0} : profile(centre - s);
  r = std::min(0.93 * r, s);
  const double fold = fold_amplitude(r, s, 24, 0.85);
  r += fold * (std::cos(24 * angle + 3 * s) - 1) / 2;
  return polar(r, angle, z + 0.02 * std::sin(7 * p + 5 * q + 6 * t));
}

Vec3d funnel(Param uv, double) {
  const auto [r, z] = profile(uv[1]);
  return polar(r, uv[0], z);
}

}  // namespace

ScenePtr make_funnel(double scale) {
  const Range side{-kHalf, kHalf, refine(90, scale)};
  std::vector<Part> parts{grid("cloth", side, side), grid("funnel", {0, 2 * kPi, refine(48, scale, 3)},
                                                          {0, kSlope + kTubeLength, refine(24, scale)}, true)};
  parts[0].formula = cloth;
  parts[1].formula = funnel;
  parts[1].mesh.is_static = true;
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
