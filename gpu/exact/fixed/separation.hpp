#pragma once
// Features that a direction keeps apart: their differences are linear in time, and so are the differences' components
// along a fixed direction d. Where all of them are above the contact distance at both ends of the step, they are so
// between. The bounds of differences.hpp hold here, too.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

/// A direction shows nothing, or that there is no contact before the end, or that there is none at all.
enum class Apart : uint8_t { kPerhaps, kBeforeEnd, kAlways };

template <ContactKind kind, int W>
class Separation {
 public:
  COLLIDED_HD Separation(const Differences<kind, W>& features, const Integer<W>& limit)
      : features_(features), squared_(limit * limit) {}

  /// The first of the features' common normals and of the differences at both ends that shows something.
  COLLIDED_HD Apart look() const {
    for (int at = 1; at >= 0; --at) {
      if (const Apart apart = along(normal(at)); apart != Apart::kPerhaps) return apart;
      for (int i = 0; i < kCount; ++i)
        if (const Apart apart = along(features_.d[i].p[at]); apart != Apart::kPerhaps) return apart;
    }
    return Apart::kPerhaps;
  }

 private:
  static constexpr int kCount = Differences<kind, W>::kCount;

  COLLIDED_HD Vec3<Integer<2 * W>> normal(int at) const {
    Vec3<Integer<2 * W>> sides[Sides<kind>::kCount];
    for (int i = 0; i < Sides<kind>::kCount; ++i)
      sides[i] = wide_cross(features_.d[Sides<kind>::at(i).p].p[at], features_.d[Sides<kind>::at(i).q].p[at]);
    return normal_of<kind>(sides);
  }
  template <int N>
  COLLIDED_HD Apart along(const Vec3<Integer<N>>& d) const {
    if (is_zero(d)) return Apart::kPerhaps;
    const auto limit = squared_ * wide_dot(d, d);
    const int side = wide_dot(features_.d[0].p[0], d).sign();
    bool touches_at_end = false;
    for (int i = 0; i < kCount; ++i)
      for (int at = 0; at < 2; ++at) {
        const auto way = wide_dot(features_.d[i].p[at], d);
        if (way.sign() != side) return Apart::kPerhaps;
        const int above = (way * way - limit).sign();
        if (above < 0 || (above == 0 && at == 0)) return Apart::kPerhaps;
        touches_at_end = touches_at_end || above == 0;
      }
    return touches_at_end ? Apart::kBeforeEnd : Apart::kAlways;
  }

  const Differences<kind, W>& features_;
  const Integer<2 * W> squared_;
};

}  // namespace collided::exact::fixed
