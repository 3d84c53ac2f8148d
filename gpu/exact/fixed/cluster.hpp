#pragma once
// Roots of the volume that lie so close together that double precision takes them for one. Features that are scaled
// through one point, with rounded coordinates, have three of them within about 2^-53. All roots are then in a short
// window, and within it the features are small and ordinary. Their differences at its ends are exact integers, which
// mostly need no more bits than the coordinates did.

#include "gpu/exact/fixed/differences.hpp"
#include "gpu/exact/fixed/root.hpp"

namespace collided::exact::fixed {

/// An interval of 2^bits units of time.
struct Window {
  uint64_t begin = 0;
  int bits = kTimeBits;

  COLLIDED_HD uint64_t end() const { return begin + (uint64_t{1} << bits); }
  /// A time in the window's own 2^-60, in those of the step.
  COLLIDED_HD uint64_t time(uint64_t local) const { return begin + (local >> (kTimeBits - bits)); }
  /// The one of its size, in steps of half its length, with t in its middle half.
  COLLIDED_HD static Window around(uint64_t t, int bits) {
    const uint64_t quarter = uint64_t{1} << (bits - 2);
    return {((t + quarter) / (2 * quarter) - 1) * 2 * quarter, bits};
  }
};

/// True if f has all its roots in (0, 1) in `window`, which is set to lie around where they seem to be.
template <int N>
COLLIDED_HD bool find_cluster(const Cubic<N>& f, Window& window) {
  constexpr double kNoise = 0x1p-40;  // far above double's rounding and a cluster's values
  double c[4], largest = 0;
  for (int i = 0; i < 4; ++i) c[i] = to_double(f.c[i]), largest = max(largest, magnitude(c[i]));
  // Second derivatives at both ends, but for a factor, and their root: the mean of three roots.
  const double at_begin = 3 * c[0] - 2 * c[1] + c[2], at_end = c[1] - 2 * c[2] + 3 * c[3];
  const double t = at_begin / (at_begin - at_end), s = 1 - t;
  if (!(t > 0x1p-16 && s > 0x1p-16)) return false;
  const double value = ((c[3] * t + c[2] * s) * t + c[1] * s * s) * t + c[0] * s * s * s;
  if (!(magnitude(value) < kNoise * largest)) return false;
  // Rounding of F64 and of F32 coordinates parts roots by 2^7 and 2^36 units of time, or a few times that.
  constexpr int kBits[] = {11, 17, 37, 43};
  for (int i = 0; i < 4; ++i) {
    window = Window::around(static_cast<uint64_t>(t * 0x1p60), kBits[i]);
    if (f.on(0, window.begin).sign_changes() == 0 && f.on(window.end(), kOne).sign_changes() == 0) return true;
  }
  return false;
}

/// The differences at both ends of a window, as multiples of the largest power of two that divides them all.
template <ContactKind kind, int W>
class InWindow {
 public:
  static constexpr int kCount = Differences<kind, W>::kCount;

  COLLIDED_HD InWindow(const Differences<kind, W>& features, const Window& window) {
    Integer<W + 1> any = Integer<W + 1>::of(0);
    for (int i = 0; i < kCount; ++i) {
      d_[i] = {{features.d[i].at(window.begin), features.d[i].at(window.end())}};
      for (const Vec3<Integer<W + 1>>& p : d_[i].p) see(p.x, any), see(p.y, any), see(p.z, any);
    }
    shift_ = any.is_zero() ? 0 : trailing_zeros(any);
    bits_ = any.is_zero() ? 0 : used_bits(any) - shift_;
  }
  /// True if V limbs will do for the decisions: differences below 2^(64 V - 3).
  template <int V>
  COLLIDED_HD bool fits() const {
    return bits_ <= 64 * V - 3;
  }
  template <int V>
  COLLIDED_HD Differences<kind, V> features() const {
    Differences<kind, V> out;
    for (int i = 0; i < kCount; ++i)
      for (int at = 0; at < 2; ++at) {
        const Vec3<Integer<W + 1>>& p = d_[i].p[at];
        out.d[i].p[at] = {shifted<V>(p.x), shifted<V>(p.y), shifted<V>(p.z)};
      }
    return out;
  }

 private:
  COLLIDED_HD static void see(const Integer<W + 1>& x, Integer<W + 1>& any) {
    const Integer<W + 1> size = x.is_negative() ? Integer<W + 1>::of(0) - x : x;
    for (int i = 0; i <= W; ++i) any.limb[i] |= size.limb[i];
  }
  template <int V>
  COLLIDED_HD Integer<V> shifted(const Integer<W + 1>& x) const {
    return resized<V>(shifted_right(x, shift_));
  }

  Moving<W + 1> d_[kCount];
  int shift_, bits_;
};

}  // namespace collided::exact::fixed
