#pragma once
// How far ahead to look next for features that come closer: a guess that costs no guarantee, only iterations.

#include "gpu/base/choose.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// Newton's method on the gap, kept a little short of contact, with what the last success told of the gap's second
/// derivative; and a limit, for directions that turn too far no longer keep the features apart.
template <class Number>
struct PaceOf {
  Number share = kShare;    ///< of the gap that is left: squared after a success, as the error of Newton's method is
  Number bend = 0;          ///< at most 0: how much sooner than by its speed the gap closes, per square of time
  Number limit = 1;         ///< longest step that is worth a try
  Number growth = 4;        ///< of the limit after a success; less once there was a failure
  Number shrink = kShrink;  ///< of the limit after a failure; its square after the next

  /// A time after t at which the features should still be apart; 1 if they do not come closer, t if there is no room.
  template <class Work>
  COLLIDED_HD Work ahead_of(Work t, Work gap, Work speed, Work least_gap) const {
    const Work most = min(Work(1), t + static_cast<Work>(limit));
    const Work room = gap - max(static_cast<Work>(share) * gap, least_gap);
    return replace_where(room > 0, t, [&] {
      const Work curve = static_cast<Work>(bend);
      const Work closing = square_root(speed * speed - 4 * curve * room) - speed;
      return replace_where(closing > 0, most, [&] { return min(most, t + 2 * room / closing); });
    });
  }
  /// After a step on which the features were apart; gap and speed are those before it.
  template <class Work>
  COLLIDED_HD void succeed(Work step, Work gap, Work speed, Work gap_then) {
    const Work off = gap_then - (gap + step * speed);
    // Twice: it may bend more further on.
    bend = replace_where(off < 0, Number(0), [&] { return static_cast<Number>(2 * off / (step * step)); });
    share = max(share * share, Number(kLeastShare));
    limit = growth * max(limit, static_cast<Number>(step));
    shrink = kShrink;
  }
  template <class Work>
  COLLIDED_HD void fail(Work step) {
    limit = shrink * static_cast<Number>(step);
    shrink = shrink * shrink;
    growth = 2;
  }

 private:
  static constexpr float kShare = 1.0f / 16, kShrink = 0.5f, kLeastShare = 1e-6f;
};
using Pace = PaceOf<float>;

}  // namespace collided
