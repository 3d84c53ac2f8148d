// Scene reef_knot: two ribbons, each bent into a bight through the other's, pulled tight until they crumple.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

namespace {

constexpr double kEnd = 3, kTail = 9, kBend = 0.9, kWidth = 0.36;
constexpr double kLeg = kEnd + kTail, kLength = 2 * kLeg + kPi * kBend;

/// Half the distance between a bight's legs at x: narrower where the other ribbon's bight goes round them.
double leg_offset(double x) { return 0.5 + 0.4 * smooth(-2, 2, x); }

/// Centre line at arc length s: tail, straight leg, semicircle round (3, 0), straight leg, tail.
std::array<double, 2> centre_line(double s) {
  if (s <= kLeg) return {-kTail + s, leg_offset(-kTail + s)};
  if (s >= kLength - kLeg) return {-kTail + (kLength - s), -leg_offset(-kTail + (kLength - s))};
  const double angle = kPi / 2 - (s - kLeg) / kBend;
  return {kEnd + kBend * std::cos(angle), kBend * std::sin(angle)};
}

/// Unit vector across the ribbon, in the plane of the knot.
std::array<double, 2> across(double s) {
  const auto a = centre_line(std::max(s - 1e-3, 0.0)), b = centre_line(std::min(s + 1e-3, kLength));
  const double dx = b[0] - a[0], dy = b[1] - a[1], length = std::hypot(dx, dy);
  return {-dy / length, dx / length};
}

/// The ribbon's path shrinks by g = 1 to 0.25, but its material does not: pleats take up the lost length.
Vec3d ribbon(Param at, double t) {
  const auto [s, w] = at;
  const double g = 1 - 0.75 * smooth(0, 1, t), inside = smooth(-1, 1, 6 - std::abs(s - kLength / 2));
  const auto [x, y] = centre_line(s);
  const auto [nx, ny] = across(s);
  const double wave = 2 * kPi / 0.4;
  const double pleat = std::min(0.07, 2 / wave * std::sqrt(1 / g - 1)) * std::cos(wave * s + 0.5 * w) * inside;
  const double crumple = 0.02 * (1 - g) * std::sin(23 * s + 17 * w + 4 * t) * std::cos(11 * s - 29 * w);
  const double z = -0.3 * std::cos(kPi * std::clamp(x, -kEnd, kEnd) / kEnd);
  const double breadth = w * (0.4 + 0.6 * g);
  return {g * x + nx * (breadth + crumple), g * y + ny * (breadth + crumple), g * z + pleat + crumple};
}

}  // namespace

std::vector<Part> reef_knot_ribbons(const std::string& name, double scale, double size, Vec3d centre) {
  const Range along{0, kLength, refine(833, scale)}, over{-kWidth / 2, kWidth / 2, refine(6, scale)};
  std::vector<Part> parts{grid(name + "_a", along, over), grid(name + "_b", along, over)};
  for (int i = 0; i < 2; ++i) {
    const double sign = i == 0 ? size : -size;  // the second ribbon is the first one rotated: (-x, y, -z)
    parts[i].formula = [=](Param at, double t) -> Vec3d {
      const Vec3d p = ribbon(at, t);
      return {centre[0] + sign * p[0], centre[1] + size * p[1], centre[2] + sign * p[2]};
    };
  }
  return parts;
}

ScenePtr make_reef_knot(double scale) {
  return std::make_unique<FormulaScene>(reef_knot_ribbons("ribbon", scale, 1, {0, 0, 0}));
}

}  // namespace collided::scenes
