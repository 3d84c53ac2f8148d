#pragma once
// A triangle on the way of a screw, in rational arithmetic: it turns about an axis parallel to z by kSamples times an
// angle whose sine and cosine are rational, and rises evenly meanwhile. Whether it crosses another triangle at one of
// the sampled times is exact. The poses are the doubles nearest to the rational ones.

#include <gmpxx.h>

#include <array>
#include <optional>
#include <random>

#include "gpu/positions/pose.hpp"
#include "tests/support/case.hpp"

namespace collided::test {

class ScrewCase {
 public:
  static constexpr int kSamples = 8;

  /// Coordinates are multiples of 2^-10, so that F32 holds them.
  explicit ScrewCase(std::mt19937& random) {
    std::uniform_int_distribution<int> far(-2048, 2048), small(-600, 600), divisor(6, 60);
    const auto point = [&](auto& numbers) {
      return Vec3d{std::ldexp(numbers(random), -10), std::ldexp(numbers(random), -10),
                   std::ldexp(numbers(random), -10)};
    };
    axis_ = {std::ldexp(far(random), -10), std::ldexp(far(random), -10)};
    rise_ = mpq_class(small(random), 1024 * kSamples);
    const mpq_class tangent(1, divisor(random));  // of half the angle of a sample
    const mpq_class bottom = 1 + tangent * tangent;
    cos_ = (1 - tangent * tangent) / bottom, sin_ = 2 * tangent / bottom;
    const Vec3d at = point(far);
    for (Vec3d& p : rest_) p = plus(at, point(small));
    // Near where some corner comes by.
    const Exact near = exact_at(rest_[0], std::uniform_int_distribution<int>(1, kSamples - 1)(random));
    std::uniform_int_distribution<int> tiny(-60, 60);
    for (Vec3d& p : obstacle_)
      for (size_t k = 0; k < 3; ++k) p[k] = std::ldexp(std::round(std::ldexp(near[k].get_d(), 10)) + tiny(random), -10);
  }

  Positions rest() const { return {rest_.begin(), rest_.end()}; }
  Positions obstacle() const { return {obstacle_.begin(), obstacle_.end()}; }

  /// After `sample` of kSamples parts of the step.
  Pose pose(int sample) const {
    const auto [c, s] = turn(sample);
    const mpq_class x = axis_[0], y = axis_[1];
    Pose pose;
    pose.rows = {c.get_d(), -s.get_d(), 0, mpq_class(x - c * x + s * y).get_d(),
                 s.get_d(), c.get_d(),  0, mpq_class(y - s * x - c * y).get_d(),
                 0,         0,          1, mpq_class(sample * rise_).get_d()};
    return pose;
  }

  /// The first of the sampled times, 0 to 1, at which an edge of one triangle crosses the inside of the other, if they
  /// do not at t = 0.
  std::optional<mpq_class> first_sampled_crossing() const {
    if (crosses(0)) return {};
    for (int sample = 1; sample <= kSamples; ++sample)
      if (crosses(sample)) return mpq_class(sample, kSamples);
    return {};
  }

 private:
  using Exact = std::array<mpq_class, 3>;
  using Triangle = std::array<Exact, 3>;

  static Vec3d plus(const Vec3d& a, const Vec3d& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
  std::array<mpq_class, 2> turn(int sample) const {
    mpq_class c = 1, s = 0;
    for (int i = 0; i < sample; ++i) {
      const mpq_class next = c * cos_ - s * sin_;
      s = s * cos_ + c * sin_;
      c = next;
    }
    return {c, s};
  }
  Exact exact_at(const Vec3d& p, int sample) const {
    const auto [c, s] = turn(sample);
    const mpq_class x = p[0] - axis_[0], y = p[1] - axis_[1];
    return {c * x - s * y + axis_[0], s * x + c * y + axis_[1], p[2] + sample * rise_};
  }

  /// Sign of the volume of four points.
  static int side(const Exact& a, const Exact& b, const Exact& c, const Exact& d) {
    mpq_class m[3][3];
    const Exact* rows[3] = {&b, &c, &d};
    for (int i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k) m[i][k] = (*rows[i])[k] - a[k];
    return sgn(m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]));
  }
  static bool edge_crosses(const Exact& p, const Exact& q, const Triangle& t) {
    if (side(t[0], t[1], t[2], p) * side(t[0], t[1], t[2], q) >= 0) return false;
    const int s = side(p, q, t[0], t[1]);
    return s != 0 && s == side(p, q, t[1], t[2]) && s == side(p, q, t[2], t[0]);
  }
  static bool any_edge_crosses(const Triangle& a, const Triangle& b) {
    return edge_crosses(a[0], a[1], b) || edge_crosses(a[1], a[2], b) || edge_crosses(a[2], a[0], b);
  }
  bool crosses(int sample) const {
    Triangle body, other;
    for (size_t i = 0; i < 3; ++i) {
      body[i] = exact_at(rest_[i], sample);
      for (size_t k = 0; k < 3; ++k) other[i][k] = obstacle_[i][k];
    }
    return any_edge_crosses(body, other) || any_edge_crosses(other, body);
  }

  std::array<double, 2> axis_{};
  mpq_class rise_, cos_, sin_;
  std::array<Vec3d, 3> rest_{}, obstacle_{};
};

}  // namespace collided::test
