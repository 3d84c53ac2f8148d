#include "gpu/positions/pose.hpp"

#include <cmath>

namespace collided {
namespace {

using Vec = Vec3<double>;

/// A column of [R | t], 0 to 3.
Vec column(const Pose& pose, int k) { return {pose.r(0, k), pose.r(1, k), pose.r(2, k)}; }

/// A rotation between two poses as a unit quaternion.
struct HalfTurn {
  double cosine;
  Vec vector;
};

// R1 R0^T has the trace sum_k a_k . b_k, where a_k and b_k are the columns of R0 and R1, and its antisymmetric part is
// that of sum_k a_k x b_k = sum_k a_k x (b_k - a_k). The latter keeps the digits of small angles.
HalfTurn turn_between(const Pose& from, const Pose& to) {
  double trace = 0;
  Vec twice{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const Vec a = column(from, k), b = column(to, k);
    trace = trace + dot(a, b);
    twice = twice + cross(a, b - a);
  }
  const double cosine = 0.5 * std::sqrt(1 + trace);
  return {cosine, (1 / (4 * cosine)) * twice};
}

}  // namespace

Vec3<double> half_turn(const Pose& from, const Pose& to) { return turn_between(from, to).vector; }

// Let b be half the angle, S = sin b, r the distance of a vertex from the axis, and 2 r S the length of its chord
// across the axis. The point of the arc beside the point at a of the chord is at an angle m from the arc's middle, with
// sin m = (2a - 1) S, and off the chord by r (cos m - cos b). In units of the chord this is
//   (cos m - cos b) / (2 S) = (S^2 - sin^2 m) / (2 S (cos m + cos b)) = 2 a (1 - a) S / (cos m + cos b).
// It points along chord x axis. With v = S axis, the vertex is off by 2 a (1 - a) / (cos m + cos b) times chord x v, to
// which the slide along the axis adds nothing. The chord is affine in the vertex, so that the columns of a pose may
// stand for it. There is no division by the angle, and m is the same for all vertices: they turn as one.
Pose pose_along(const Pose& from, const Pose& to, double fraction) {
  if (fraction == 0) return from;
  if (fraction == 1) return to;
  const HalfTurn half = turn_between(from, to);
  const double from_middle = 2 * fraction - 1;
  const double squared = 1 - (from_middle * from_middle) * dot(half.vector, half.vector);
  const double bulge = 2 * (fraction * (1 - fraction)) / (half.cosine + std::sqrt(squared > 0 ? squared : 0.0));
  Pose pose = from;
  for (int k = 0; k < 4; ++k) {
    const Vec chord = column(to, k) - column(from, k);
    const Vec off = cross(chord, half.vector);
    const auto put = [&](int i, double way, double aside) {
      double& entry = pose.rows[static_cast<size_t>(4 * i + k)];
      entry = entry + (fraction * way + bulge * aside);
    };
    put(0, chord.x, off.x), put(1, chord.y, off.y), put(2, chord.z, off.z);
  }
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
