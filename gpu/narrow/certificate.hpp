#pragma once
// Certificates of contact: what makes a hit certain in real arithmetic, from bounds in the working precision.
//
// Without thickness: f, the determinant of three of the differences, changes its sign for certain between two times,
// and over all of that interval the inside conditions are above 0 for certain. f then vanishes somewhere in it; with
// n the normal, f = 0 makes the features coplanar, and the conditions put the vertex inside the triangle (the lines'
// crossing inside both edges); their sum is |n|^2, so n is not 0 there.
//   A = v-a, B = v-b, C = v-c:              f = det(A, B, C), n = AxB + BxC + CxA, conditions (BxC).n, (CxA).n, (AxB).n
//   A = a0-b0, B = a0-b1, C = a1-b0, D = a1-b1: f = det(A, B, C), n = (C-A)x(A-B), conditions
//                                           (AxB).n, (DxC).n, (CxA).n, (BxD).n
// With thickness: two explicit points of the features are at most that far apart at some time.
//
// Bounds for components at most M = `extent` (below 2), each difference at a time within 5u M of the truth:
// - det: six products of three, each within (15 + 2)u M^3, and five sums: below 256u M^3.
// - a condition: at most 48 products of four, with all roundings below 2048u M^4.
// - a condition changes by at most 4 * 48 V M^3 per unit of time, V the largest component of end - start.
// - the vector between two points whose weights are in [0, 1] and add up to 1 within 4u: below 64u M long in error.

#include "gpu/narrow/advancement.hpp"

namespace collided {

template <class Work>
COLLIDED_HD Work least_condition(const Vec3<Work> (&d)[3]) {
  const Vec3<Work> ab = cross(d[0], d[1]), bc = cross(d[1], d[2]), ca = cross(d[2], d[0]);
  const Vec3<Work> n = ab + bc + ca;
  return min(dot(ab, n), min(dot(bc, n), dot(ca, n)));
}
template <class Work>
COLLIDED_HD Work least_condition(const Vec3<Work> (&d)[4]) {
  const Vec3<Work> n = common_normal(d);
  return min(min(dot(cross(d[0], d[1]), n), dot(cross(d[3], d[2]), n)),
             min(dot(cross(d[2], d[0]), n), dot(cross(d[1], d[3]), n)));
}

template <class Work, int N>
COLLIDED_HD Work largest_motion(const Differences<Work, N>& d) {
  Work v = 0;
  for (int k = 0; k < N; ++k) v = max(v, largest_component(d.end[k] - d.start[k]));
  return v + 16 * Precision<Work>::kUnit * (v + d.extent);
}

/// -1 or 1 if the sign of the determinant of three differences is certain, else 0.
template <class Work>
COLLIDED_HD int certain_sign(const Vec3<Work>& a, const Vec3<Work>& b, const Vec3<Work>& c, Work extent) {
  const Work f = triple(a, b, c);
  const Work error = 256 * Precision<Work>::kUnit * (extent * extent * extent);
  return f > error ? 1 : f < -error ? -1 : 0;
}

/// The same of f at t.
template <class Work, int N>
COLLIDED_HD int certain_side(const Differences<Work, N>& d, Work t) {
  return certain_sign(d.at(0, t), d.at(1, t), d.at(2, t), d.extent);
}

/// Whether the features meet between `from` and `to` for certain; false says nothing.
template <class Work, int N>
COLLIDED_HD bool crosses_between(const Differences<Work, N>& d, Work from, Work to) {
  if (certain_side(d, from) * certain_side(d, to) != -1) return false;
  Vec3<Work> x[N];
  const Work half = (to - from) / 2;
  differences_at(d, from + half, x);
  const Work m = d.extent;
  const Work change = 200 * (largest_motion(d) * (m * m * m)) * half;
  return least_condition(x) > change + 2048 * Precision<Work>::kUnit * (m * m * m * m);
}

/// Whether the features are within the thickness at t for certain; false says nothing.
template <class Work, int N>
COLLIDED_HD bool touches_at(const Differences<Work, N>& d, Work t, Work thickness) {
  constexpr Work u = Precision<Work>::kUnit;
  return gap_at(d, t).length * (1 + 8 * u) + 64 * u * d.extent <= thickness * (1 - 4 * u);
}

constexpr double kNeverCertain = 2;

/// A time by which a hit that advance() found at t has certainly come; kNeverCertain if it may be none.
template <class Work, int N>
COLLIDED_HD double certain_by(const Differences<Work, N>& d, Work t, Work thickness) {
  constexpr int kWidths = 4;
  // Wide enough for f to leave its rounding errors behind, narrow enough for the conditions to hold still.
  Work width = sizeof(Work) == 8 ? Work(1e-10) : Work(1e-5);
  for (int i = 0; i < kWidths; ++i, width = width * (sizeof(Work) == 8 ? 100 : 10)) {
    const Work from = max(t - width, Work(0)), to = min(t + width, Work(1));
    if (thickness > 0 ? touches_at(d, to, thickness) : crosses_between(d, from, to)) return to;
  }
  return kNeverCertain;
}

}  // namespace collided
