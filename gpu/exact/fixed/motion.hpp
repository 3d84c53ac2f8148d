#pragma once
// Vectors that move linearly, and times.

#include "gpu/exact/fixed/integer.hpp"

namespace collided::exact::fixed {

/// Times are multiples of 2^-60 here.
constexpr int kTimeBits = 60;
constexpr uint64_t kOne = uint64_t{1} << kTimeBits;

/// t and s = 1 - t, both times 2^60.
struct Time {
  Integer<1> t, s;
  COLLIDED_HD explicit Time(uint64_t k)
      : t(Integer<1>::of(static_cast<int64_t>(k))), s(Integer<1>::of(static_cast<int64_t>(kOne - k))) {}
};

/// k / 2^60 as a double, rounded down.
COLLIDED_HD inline double time_of(uint64_t k) {
  int dropped = 0;
  while ((k >> dropped >> 53) != 0) ++dropped;
  return static_cast<double>(k >> dropped << dropped) * 0x1p-60;
}

/// p[0] at t = 0, p[1] at t = 1.
template <int N>
struct Moving {
  Vec3<Integer<N>> p[2];

  /// Times 2^60.
  COLLIDED_HD Vec3<Integer<N + 1>> at(uint64_t k) const {
    const Time time(k);
    return {p[0].x * time.s + p[1].x * time.t, p[0].y * time.s + p[1].y * time.t, p[0].z * time.s + p[1].z * time.t};
  }
};

/// P x Q of moving vectors as c[0] s^2 + c[1] s t + c[2] t^2.
template <int N>
struct MovingProduct {
  Vec3<Integer<2 * N>> c[3];

  COLLIDED_HD MovingProduct(const Moving<N>& p, const Moving<N>& q)
      : c{wide_cross(p.p[0], q.p[0]), wide_cross(p.p[0], q.p[1]) + wide_cross(p.p[1], q.p[0]),
          wide_cross(p.p[1], q.p[1])} {}
};

/// What double precision knows of moving vectors while t is in [k, k + 1] / 2^60, in units of theirs times 2^-60: their
/// components at k, within 2^-51 of each, by how much they change at most, and what they are at most.
struct Nearby {
  double change = 0, largest = 0;

  template <int N>
  COLLIDED_HD Vec3<double> see(const Moving<N>& a, uint64_t k) {
    const Vec3<double> now = to_double(a.at(k));
    change = max(change, largest_component(to_double(a.p[1] - a.p[0])) * (1 + 0x1p-50));
    largest = max(largest, largest_component(now) + change);
    return now;
  }
};

}  // namespace collided::exact::fixed
