#pragma once
// Features that are scaled through one point: each of their differences at t = 1 is the same multiple of itself at
// t = 0. All times show the same shape in another size, so features that do not touch at the start touch at most when
// that shape has shrunk to a point. Their volume then has a root of multiplicity three, which no halving isolates.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

template <ContactKind kind, int W>
class Scaling {
 public:
  COLLIDED_HD explicit Scaling(const Differences<kind, W>& features) {
    for (const Moving<W>& d : features.d) {
      see(d.p[0].x, d.p[1].x);
      see(d.p[0].y, d.p[1].y);
      see(d.p[0].z, d.p[1].z);
    }
  }
  /// True if the features only change their size, and have one at the start.
  COLLIDED_HD bool is_scaling() const { return is_scaling_ && has_pivot_; }
  /// True if they shrink to a point at the end of the step, or before it.
  COLLIDED_HD bool vanishes() const { return from_.sign() * to_.sign() <= 0; }
  COLLIDED_HD bool vanishes_at_end() const { return to_.is_zero(); }
  /// The time at which they shrink to a point before the end, rounded down to a multiple of 2^-60.
  COLLIDED_HD uint64_t time() const {
    const Integer<W> from = from_.is_negative() ? -from_ : from_,
                     whole = from_.is_negative() ? to_ - from_ : from_ - to_;
    uint64_t k = 0;
    Integer<W> rest = from;  // long division of from / whole, which is below 1
    for (int i = 0; i < kTimeBits; ++i) {
      rest = rest + rest;
      const Integer<W> less = rest - whole;
      k = 2 * k + (less.is_negative() ? 0 : 1);
      if (!less.is_negative()) rest = less;
    }
    return k;
  }

 private:
  /// Compares the scale of one component with that of the first one that is not 0 at the start.
  COLLIDED_HD void see(const Integer<W>& from, const Integer<W>& to) {
    if (!is_scaling_) return;
    if (has_pivot_)
      is_scaling_ = (from_ * to - from * to_).is_zero();
    else if (from.is_zero())
      is_scaling_ = to.is_zero();
    else
      from_ = from, to_ = to, has_pivot_ = true;
  }

  Integer<W> from_{}, to_{};  // the pivot at both ends
  bool is_scaling_ = true, has_pivot_ = false;
};

}  // namespace collided::exact::fixed
