#pragma once
// The small formulas that the procedural scenes share.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "client/scenes/scene.hpp"

namespace collided::scenes {

inline constexpr double kPi = 3.14159265358979323846;

/// Smooth step from 0 at x <= a to 1 at x >= b.
inline double smooth(double a, double b, double x) {
  const double u = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

/// Amplitude of k folds that lets a ring of material radius s fit on a circle of radius r; at most c * r.
inline double fold_amplitude(double r, double s, int k, double c) {
  if (r <= 0) return 0;
  return std::min(c * r, 2 * r / k * std::sqrt(std::max(s / r - 1, 0.0)));
}

/// A number in [0, 1) from two integers (the mixing steps of splitmix64): the same on every machine.
inline double hash01(uint64_t n, uint64_t stream) {
  uint64_t z = n * 0x9E3779B97F4A7C15ull + stream * 0xD1B54A32D192ED03ull + 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-53;
}

inline Vec3d polar(double r, double angle, double z) { return {r * std::cos(angle), r * std::sin(angle), z}; }

}  // namespace collided::scenes
