// Scene cloth_ball: a cloth falls over a ball, wraps it and is twisted by it.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

namespace {

constexpr double kHalf = 2.6, kWrap = 1.02;

/// Radius and height of the cloth's ring of material radius s: on the ball up to `contact`, hanging below it.
std::array<double, 2> profile(double s, double contact, double t) {
  if (s < contact) return {kWrap * std::sin(s / kWrap), kWrap * std::cos(s / kWrap)};
  const double polar_angle = contact / kWrap, narrow = 1 - 0.78 * smooth(0.1, 0.9, t);
  const double length = s - contact, u = smooth(0, 0.6, length);
  return {kWrap * std::sin(polar_angle) * (1 - u + u * narrow),
          kWrap * std::cos(polar_angle) - length * (1 - 0.25 * u * (1 - narrow))};
}

Vec3d cloth(Param pq, double t) {
  const auto [p, q] = pq;
  const double s = std::hypot(p, q), angle = std::atan2(q, p);
  const double contact = kPi * (0.5 + 0.32 * smooth(0, 0.8, t)) * kWrap;
  const auto [r, z] = profile(s, contact, t);
  const double folded = r + 0.35 * fold_amplitude(r, s, 16, 0.6) * std::cos(16 * angle + 2 * s);
  const double twist = (3 * smooth(0.2, 1, t) + 0.3 * t) * smooth(0.7 * contact, contact + 1.2, s) + 0.3 * t;
  return polar(folded, angle + twist, z);
}

Vec3d ball(Param at, double t) {
  return polar(std::sin(at[1]), at[0] + 0.3 * t + 0.6 * smooth(0.2, 1, t), std::cos(at[1]));
}

}  // namespace

ScenePtr make_cloth_ball(double scale) {
  const Range side{-kHalf, kHalf, refine(212, scale)};
  std::vector<Part> parts{grid("cloth", side, side), uv_sphere("ball", refine(32, scale, 3), refine(32, scale, 3))};
  parts[0].formula = cloth;
  parts[1].formula = ball;
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
