#pragma once
// Advancement (narrow/advancement.hpp) of four pairs of features at a time, each on its own way.

#include "gpu/base/four.hpp"
#include "gpu/narrow/advancement.hpp"

namespace collided {

template <class T, int N>
Along<Four<T>, N> select(const FourMask<T>& is, const Along<Four<T>, N>& a, const Along<Four<T>, N>& b) {
  Along<Four<T>, N> out{select(is, a.length, b.length), select(is, a.least, b.least), {}, {}};
  for (int k = 0; k < N; ++k)
    out.start[k] = select(is, a.start[k], b.start[k]), out.end[k] = select(is, a.end[k], b.end[k]);
  return out;
}
template <class T, int N>
View<Four<T>, N> select(const FourMask<T>& is, const View<Four<T>, N>& a, const View<Four<T>, N>& b) {
  return {select(is, a.gap, b.gap), select(is, a.speed, b.speed), select(is, a.directed, b.directed)};
}
template <class T>
PaceOf<Four<T>> select(const FourMask<T>& is, const PaceOf<Four<T>>& a, const PaceOf<Four<T>>& b) {
  return {select(is, a.share, b.share), select(is, a.bend, b.bend), select(is, a.limit, b.limit),
          select(is, a.growth, b.growth), select(is, a.shrink, b.shrink)};
}

/// What four advancements found out in an iteration; bit k: the k-th.
struct FourOutcomes {
  uint32_t over, hits;
};

template <int N>
class FourAdvancements {
  using Work = Four<float>;

 public:
  explicit FourAdvancements(int max_iterations) : max_iterations_(static_cast<float>(max_iterations)) {}

  /// The `lane`-th begins at t = 0 with what is the `from`-th there.
  void begin(int lane, const Differences<Work, N>& d, const Work& thickness, const Work& delta, int from) {
    for (int k = 0; k < N; ++k) {
      copy(d_.start[k], lane, d.start[k], from);
      copy(d_.end[k], lane, d.end[k], from);
    }
    d_.extent.set(lane, d.extent[from]);
    thickness_.set(lane, thickness[from]);
    delta_.set(lane, delta[from]);
    t_.set(lane, 0), next_.set(lane, 0), iterations_.set(lane, 0);
    const Pace pace;
    pace_.share.set(lane, pace.share), pace_.bend.set(lane, pace.bend), pace_.limit.set(lane, pace.limit);
    pace_.growth.set(lane, pace.growth), pace_.shrink.set(lane, pace.shrink);
  }

  /// Of one that is a hit.
  Progress progress(int lane) const {
    return {t_[lane], {pace_.share[lane], pace_.bend[lane], pace_.limit[lane], pace_.growth[lane], pace_.shrink[lane]}};
  }

  /// As Advancement::iterate(1). The outcome of one that is over already says nothing.
  [[gnu::flatten]] FourOutcomes iterate() {
    const View<Work, N> then = View<Work, N>::at(d_, next_, {thickness_, thickness_});
    const Mask<Work> misses = arrive(then);
    iterations_ = iterations_ + 1;
    return choose_next(misses);
  }

 private:
  static void copy(Vec3<Work>& to, int lane, const Vec3<Work>& from, int k) {
    to.x.set(lane, from.x[k]), to.y.set(lane, from.y[k]), to.z.set(lane, from.z[k]);
  }

  /// Which are certainly apart.
  Mask<Work> arrive(const View<Work, N>& then) {
    const Work step = next_ - t_;
    const Mask<Work> begins = iterations_ == 0, turns = turns_ & !begins;
    const Mask<Work> apart = apart_while_turning(now_.directed, then.directed, t_, next_);
    const Mask<Work> fails = turns & !apart, misses = turns & apart & (next_ == 1),
                     succeeds = !(begins | fails | misses);
    PaceOf<Work> slower = pace_, faster = pace_;
    slower.fail(step);
    faster.succeed(step, now_.gap, now_.speed, then.gap);
    pace_ = select(fails, slower, select(succeeds, faster, pace_));
    now_ = select(fails, now_, then);
    t_ = select(succeeds, next_, t_);
    return misses;
  }

  FourOutcomes choose_next(const Mask<Work>& misses) {
    const Reach<Work> reach = now_.directed.reach();
    const Mask<Work> apart = misses | (reach.until > 1);
    const Mask<Work> contact = !(reach.until > t_) | !(reach.separation > delta_);
    const Mask<Work> hits = !apart & (contact | (iterations_ > max_iterations_));
    const Work rounding = 32 * Precision<Work>::kUnit * d_.extent;
    const Work ahead = pace_.ahead_of(t_, now_.gap - thickness_, now_.speed, rounding);
    turns_ = ahead > reach.until;
    next_ = select(turns_, ahead, reach.until);
    return {(apart | hits).bits(), hits.bits()};
  }

  Differences<Work, N> d_{};
  Work thickness_ = 0, delta_ = 0;
  Work t_ = 0, next_ = 0, iterations_ = 0, max_iterations_;
  PaceOf<Work> pace_;
  View<Work, N> now_{};
  Mask<Work> turns_{};
};

}  // namespace collided
