#pragma once
// Positions as 16-bit fixed point in a box (Q16), and how far what comes out is from what went in.

#include <algorithm>
#include <cmath>

#include "gpu/base/host_device.hpp"
#include "gpu/base/vec3.hpp"
#include "gpu/positions/format.hpp"
#include "gpu/types.hpp"

namespace collided {

/// A box divided into 65535 steps along each axis.
struct Quantization {
  Vec3<double> lower{}, step{};
  bool is_on = false;

  static constexpr double kLast = 65535;

  Quantization() = default;
  /// None where the box is absent.
  explicit Quantization(const std::optional<PositionBox>& box) : is_on(box.has_value()) {
    if (!is_on) return;
    const auto& lo = box->lower;
    const auto& hi = box->upper;
    lower = {lo[0], lo[1], lo[2]};
    step = {(hi[0] - lo[0]) / kLast, (hi[1] - lo[1]) / kLast, (hi[2] - lo[2]) / kLast};
  }

  /// fl(lower + fl(q * step)), each operation rounded to binary64 (none fused), then to binary32.
  COLLIDED_HD Vec3<float> decode(const Vec3<uint16_t>& q) const {
    return {decode(q.x, lower.x, step.x), decode(q.y, lower.y, step.y), decode(q.z, lower.z, step.z)};
  }

  /// Largest magnitude of a coordinate in the box.
  double largest() const {
    const auto along = [](double lo, double size) { return std::fmax(std::fabs(lo), std::fabs(lo + kLast * size)); };
    return std::fmax(along(lower.x, step.x), std::fmax(along(lower.y, step.y), along(lower.z, step.z)));
  }

  /// No decoded position is farther than this from the one that was encoded, if that was in the box and went to the
  /// nearest step.
  double error() const {
    if (!is_on) return 0;
    return std::sqrt(square(error_along(lower.x, step.x)) + square(error_along(lower.y, step.y)) +
                     square(error_along(lower.z, step.z))) *
           (1 + 0x1p-50);
  }

 private:
  COLLIDED_HD static float decode(uint16_t q, double lower, double step) {
    const double way = static_cast<double>(q) * step;
    return static_cast<float>(lower + way);
  }
  static double square(double x) { return x * x; }
  /// Half a step, and the roundings of step, product and sum, which are below 2^-50 of the box's largest coordinate,
  /// and of the result to binary32, 2^-24 of it, or half of the least number there is.
  static double error_along(double lower, double step) {
    const double largest = std::fabs(lower) + kLast * step;
    return (step / 2 + 0x1.0001p-24 * largest) * (1 + 0x1p-50) + 0x1p-149;
  }
};

/// A rigid mesh whose positions were encoded stays within so many times the largest coordinate of the box.
constexpr double kMostBoxes = 8;

/// Largest magnitude of a coordinate that a transform may give to a rigid mesh's vertices.
inline double reach_limit(const SceneSpec& spec) {
  const double limit = coordinate_limit(spec.scalar);
  return spec.quantized_in ? std::fmin(limit, kMostBoxes * Quantization(spec.quantized_in).largest()) : limit;
}

/// What a scene's positions may be off from those that were encoded, moved by transforms, and rounded again.
inline double encoding_error(const SceneSpec& spec) {
  const Quantization quantization(spec.quantized_in);
  const bool moves = std::any_of(spec.meshes.begin(), spec.meshes.end(),
                                 [](const MeshSpec& mesh) { return mesh.motion == MeshMotion::kRigid; });
  const double rounding = moves && quantization.is_on ? 0x1.cp-24 * kMostBoxes * quantization.largest() : 0;
  return quantization.error() + rounding;
}

}  // namespace collided
