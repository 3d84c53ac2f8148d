// Scene flamenco: a dancer spins; six skirt layers of different ruffles brush along each other.

#include "client/scenes/families.hpp"
#include "client/scenes/math.hpp"

namespace collided::scenes {

namespace {

Vec3d sway(Vec3d at, double t) {
  return {at[0] + 0.06 * std::sin(2 * kPi * t), at[1] + 0.04 * std::cos(2 * kPi * t), at[2]};
}

Vec3d skirt(int layer, Param at, double t) {
  const auto [angle, h] = at;
  const int k = 9 + 3 * layer;
  const double beat = std::sin(2 * kPi * t);
  const double r = 0.14 + 0.006 * layer + (0.30 + 0.10 * (layer % 3) * (0.6 + 0.4 * beat)) * h +
                   0.16 * h * std::cos(k * angle + 0.7 * layer + 3 * t) + 0.03 * h * std::cos(3 * k * angle + 5 * t);
  const double z = 1 - 0.055 * layer - h * (0.95 - 0.15 * beat * std::cos(2 * angle));
  return sway(polar(r, angle + 1.5 * t + 0.4 * h, z), t);
}

/// From below the waist (z = 0.6) to the shoulders (z = 1.5).
Vec3d torso(Param at, double t) {
  const auto [angle, v] = at;
  const double r = 0.11 + 0.05 * smooth(0.4, 0.8, v) - 0.1 * smooth(0.85, 1, v);
  return sway(polar(r, angle + 1.5 * t, 0.6 + 0.9 * v), t);
}

/// A bent tube from the shoulder that rises and falls; side is -1 or 1.
Vec3d arm(double side, Param at, double t) {
  const auto [angle, v] = at;
  const double lift = 0.9 * std::sin(2 * kPi * t + side) * v, thick = 0.035 * (1 - 0.4 * v);
  const double x = side * (0.15 + 0.5 * v * std::cos(lift)), y = thick * std::cos(angle);
  const double z = 1.38 + 0.5 * v * std::sin(lift) + thick * std::sin(angle), turn = 1.5 * t;
  return sway({x * std::cos(turn) - y * std::sin(turn), x * std::sin(turn) + y * std::cos(turn), z}, t);
}

}  // namespace

ScenePtr make_flamenco(double scale) {
  std::vector<Part> parts;
  const auto tube = [&](std::string name, uint32_t around, uint32_t along, double length) {
    const Range ring{0, 2 * kPi, refine(around, scale, 3)};
    parts.push_back(grid(std::move(name), ring, {0, length, refine(along, scale)}, true));
  };
  for (int layer = 0; layer < 6; ++layer) {
    tube("skirt" + std::to_string(layer), 180, 20, 0.55 + 0.07 * layer);
    parts.back().formula = [layer](Param at, double t) { return skirt(layer, at, t); };
  }
  tube("torso", 64, 40, 1);
  parts.back().formula = torso;
  for (const double side : {-1.0, 1.0}) {
    tube(side < 0 ? "arm_left" : "arm_right", 16, 10, 1);
    parts.back().formula = [side](Param at, double t) { return arm(side, at, t); };
  }
  return std::make_unique<FormulaScene>(std::move(parts));
}

}  // namespace collided::scenes
