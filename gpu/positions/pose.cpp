#include "gpu/positions/pose.hpp"

#include <cmath>

namespace collided {
namespace {

using Vec = Vec3<double>;

/// A column of [R | t], 0 to 3.
Vec column(const Pose& pose, int k) { return {pose.r(0, k), pose.r(1, k), pose.r(2, k)}; }

/// A rotation as a unit quaternion; what it does to a vector is a sum of three parts.
struct HalfTurn {
  double cosine;
  Vec vector;

  /// along x + across ((v . x) v) + turned (v x x), v the vector.
  Vec sum(double along, double across, double turned, const Vec& x) const {
    const Vec parallel = (across * dot(vector, x)) * vector, aside = turned * cross(vector, x);
    return along * x + (parallel + aside);
  }
};

// Let a_k and b_k be the columns of R0 and R1. The trace of R1 R0^T is sum_k a_k . b_k. Its antisymmetric part is that
// of sum_k a_k x b_k = sum_k a_k x (b_k - a_k), and the second form keeps the digits of small angles. With 1 added to
// the trace, the sums are 2 (1 + cos) and 2 sin times the axis. Their ratio is the tangent of half the angle.
HalfTurn turn_between(const Pose& from, const Pose& to) {
  double cosine = 1;
  Vec sine{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const Vec a = column(from, k), b = column(to, k);
    cosine = cosine + dot(a, b);
    sine = sine + cross(a, b - a);
  }
  const double length = std::sqrt(cosine * cosine + dot(sine, sine));
  return {cosine / length, (1 / length) * sine};
}

}  // namespace

Vec3<double> half_turn(const Pose& from, const Pose& to) { return turn_between(from, to).vector; }

// Let b be half the angle, S = sin b, and v = S axis. A vertex at distance r from the axis has a chord of length 2 r S
// across it. Take the point of the arc that lies beside the point at f of the chord. It is at an angle m from the arc's
// middle, with sin m = (2f - 1) S. It is off the chord by r (cos m - cos b), which in units of the chord is
//   (cos m - cos b) / (2 S) = (S^2 - sin^2 m) / (2 S (cos m + cos b)) = 2 f (1 - f) S / (cos m + cos b).
// The direction is that of chord x axis. So the vertex is off by bulge = 2 f (1 - f) / (cos m + cos b) times chord x v.
// The slide along the axis adds nothing to this product. The chord is affine in the vertex, and the columns of a pose
// may stand for it. The angle m is the same for all vertices, so that they turn as one. Nothing is divided by the
// angle.
//
// This formula gives the translation. For R it would lose digits near half a turn, and the loss adds up over many
// steps. So R1 is turned back first, and blended with R0. The blend is then turned by m + b. With c = cos b, the
// coefficients of that turn follow from
//   sin(m + b) = 2 S (f c + bulge S^2),   1 - cos(m + b) = 2 S^2 (f - bulge c).
Pose pose_along(const Pose& from, const Pose& to, double fraction) {
  if (fraction == 0) return from;
  if (fraction == 1) return to;
  const HalfTurn half = turn_between(from, to);
  const double squared = dot(half.vector, half.vector), from_middle = 2 * fraction - 1;
  const double of_middle = 1 - (from_middle * from_middle) * squared;
  const double bulge = 2 * (fraction * (1 - fraction)) / (half.cosine + std::sqrt(of_middle > 0 ? of_middle : 0.0));
  const double turned = fraction * half.cosine + bulge * squared, across = fraction - bulge * half.cosine;

  Pose pose;
  const auto put = [&](int k, const Vec& v) {
    pose.rows[static_cast<size_t>(k)] = v.x;
    pose.rows[static_cast<size_t>(4 + k)] = v.y;
    pose.rows[static_cast<size_t>(8 + k)] = v.z;
  };
  for (int k = 0; k < 3; ++k) {
    const Vec a = column(from, k);
    const Vec back = half.sum(1 - 2 * squared, 2, -2 * half.cosine, column(to, k));
    put(k, half.sum(1 - 2 * (across * squared), 2 * across, 2 * turned, a + fraction * (back - a)));
  }
  const Vec t = column(from, 3), way = column(to, 3) - t;
  put(3, t + (fraction * way + bulge * cross(way, half.vector)));
  return pose;
}

double rotation_defect(const Pose& pose) {
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      double product = i == k ? -1 : 0;
      for (int row = 0; row < 3; ++row) product += pose.r(row, i) * pose.r(row, k);
      sum += product * product;
    }
  return std::sqrt(sum);
}

double determinant(const Pose& pose) {
  const Vec3<double> a{pose.r(0, 0), pose.r(0, 1), pose.r(0, 2)}, b{pose.r(1, 0), pose.r(1, 1), pose.r(1, 2)},
      c{pose.r(2, 0), pose.r(2, 1), pose.r(2, 2)};
  return triple(a, b, c);
}

}  // namespace collided
