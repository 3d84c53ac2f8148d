#pragma once
// Features that move in one plane, which moves along but does not turn: apart at first, they meet when the end of an
// edge, or the vertex, comes to a side. The cross products P x Q of all sides are then multiples of one vector at all
// times, and a point comes to a side where one of them vanishes while P and Q do not lead to the same side.

#include "gpu/exact/fixed/differences.hpp"
#include "gpu/exact/fixed/root.hpp"

namespace collided::exact::fixed {

/// A component of a vector by number.
template <class T>
COLLIDED_HD const T& component(const Vec3<T>& a, int axis) {
  return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}

template <ContactKind kind, int W>
class Sliding {
 public:
  COLLIDED_HD explicit Sliding(const Differences<kind, W>& features) : d_(features.d) {}

  /// kFound: they meet in (0, 1), at first in [time(), time() + 1) / 2^60. kGoOn: if they meet, it is at the end.
  COLLIDED_HD Look look() {
    if (!find_plane()) return Look::kOpen;
    for (int i = 0; i < Sides<kind>::kCount; ++i)
      if (look_at(Sides<kind>::at(i)) == Look::kOpen) return Look::kOpen;
    return first_ < kOne ? Look::kFound : Look::kGoOn;
  }
  COLLIDED_HD uint64_t time() const { return first_; }

 private:
  COLLIDED_HD MovingProduct<W> product(const Side& side) const { return {d_[side.p], d_[side.q]}; }

  /// Whether all products are multiples of one vector, of which axis_ is a component that is not 0.
  COLLIDED_HD bool find_plane() {
    Vec3<Integer<2 * W>> normal{};
    bool has_normal = false;
    for (int i = 0; i < Sides<kind>::kCount; ++i) {
      const MovingProduct<W> pq = product(Sides<kind>::at(i));
      for (const Vec3<Integer<2 * W>>& c : pq.c) {
        if (has_normal && !is_zero(wide_cross(c, normal))) return false;
        if (!has_normal && !is_zero(c)) normal = c, has_normal = true;
      }
    }
    while (axis_ < 2 && component(normal, axis_).is_zero()) ++axis_;
    return has_normal;
  }
  /// Finds when something first comes to a side.
  COLLIDED_HD Look look_at(const Side& side) {
    const MovingProduct<W> pq = product(side);
    const Integer<2 *W>&a = component(pq.c[0], axis_), &b = component(pq.c[1], axis_), &c = component(pq.c[2], axis_);
    const Cubic<2 * W> f{{a, a + b, b + c, c}};  // times s + t
    if (f.first_sign() == 0) return Look::kOpen;
    return for_each_root(f, [&](uint64_t k, bool) {
      Nearby nearby;
      const Vec3<double> p = nearby.see(d_[side.p], k), q = nearby.see(d_[side.q], k);
      const double size = nearby.largest, error = (64 * 0x1p-53 * size + 8 * nearby.change) * size, along = dot(p, q);
      if (along > error) return Look::kGoOn;
      if (!(along < -error)) return Look::kOpen;
      first_ = min(first_, k);
      return Look::kFound;
    });
  }

  const Moving<W>* d_;
  int axis_ = 0;
  uint64_t first_ = kOne;
};

}  // namespace collided::exact::fixed
