#pragma once
// The decisions of exact.hpp, without thickness, for what most queries are: coordinates whose exponents lie together,
// and features that touch at an end of the step, or meet between where no two conditions hold just so. The rest is left
// open.

#include "gpu/exact/fixed/cluster.hpp"
#include "gpu/exact/fixed/crossing.hpp"
#include "gpu/exact/fixed/scaling.hpp"
#include "gpu/exact/fixed/sliding.hpp"
#include "gpu/exact/fixed/soon.hpp"
#include "gpu/exact/fixed/touching.hpp"

namespace collided::exact::fixed {

/// `kOpen`: not decided.
enum class Outcome : uint8_t { kOpen, kApart, kAtStart, kBetween, kAtEnd };

struct Verdict {
  Outcome outcome = Outcome::kOpen;
  double toi = 1;  ///< as ExactImpact::toi
};

/// An outcome and its time, rounded down to a multiple of 2^-60.
struct Found {
  Outcome outcome = Outcome::kOpen;
  uint64_t time = kOne;

  COLLIDED_HD Verdict verdict() const { return {outcome, time_of(time)}; }
};

template <ContactKind kind, int W>
class Decision {
 public:
  COLLIDED_HD Decision(const Unit& unit, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4])
      : features_(unit, start, end) {}
  COLLIDED_HD explicit Decision(const Differences<kind, W>& features) : features_(features) {}

  COLLIDED_HD Verdict verdict() const {
    if (touch(features_, 0)) return {Outcome::kAtStart, 0};
    if (const Scaling<kind, W> scaling(features_); scaling.is_scaling()) return found_by(scaling).verdict();
    const Cubic<3 * W> f = volume();
    Window window;
    if (f.sign_changes() > 1 && find_cluster(f, window)) return found_in(window, f).verdict();
    return found_by_roots(f).verdict();
  }
  /// The same without a look for what is special.
  COLLIDED_HD COLLIDED_CALLED Found found_by_roots() const {
    if (touch(features_, 0)) return {Outcome::kAtStart, 0};
    return found_by_roots(volume());
  }
  /// Whether they meet at a root of their volume that has no other beside it in [k, k + 1] / 2^60.
  COLLIDED_HD bool meet_at(uint64_t k) const { return Crossing<kind, W>(features_, k, true).look() == Look::kFound; }

 private:
  COLLIDED_HD static Found found_by(const Scaling<kind, W>& scaling) {
    if (!scaling.vanishes()) return {Outcome::kApart, kOne};
    if (scaling.vanishes_at_end()) return {Outcome::kAtEnd, kOne};
    return {Outcome::kBetween, scaling.time()};
  }
  COLLIDED_HD Found found_in(const Window& window, const Cubic<3 * W>& f) const {
    const InWindow<kind, W> in_window(features_, window);
    Found found;
    if (in_window.template fits<1>())
      found = Decision<kind, 1>(in_window.template features<1>()).found_by_roots();
    else if (in_window.template fits<2>())
      found = Decision<kind, 2>(in_window.template features<2>()).found_by_roots();
    if (found.outcome == Outcome::kOpen) return found;
    if (found.outcome == Outcome::kApart) return found_at_end(f);
    return {Outcome::kBetween, window.time(found.time)};
  }
  COLLIDED_HD Found found_by_roots(const Cubic<3 * W>& f) const {
    uint64_t first = kOne;
    const Look look = f.first_sign() == 0 ? slide(first) : cross_at_roots(f, first);
    if (look == Look::kOpen) return {};
    if (look == Look::kFound) return {Outcome::kBetween, first};
    return found_at_end(f);
  }
  COLLIDED_HD Found found_at_end(const Cubic<3 * W>& f) const {
    return {f.c[3].is_zero() && touch(features_, 1) ? Outcome::kAtEnd : Outcome::kApart, kOne};
  }
  COLLIDED_HD Look cross_at_roots(const Cubic<3 * W>& f, uint64_t& first) const {
    return for_each_root(f, [&](uint64_t k, bool is_alone) {
      first = k;
      return Crossing<kind, W>(features_, k, is_alone).look();
    });
  }
  COLLIDED_HD Look slide(uint64_t& first) const {
    Sliding<kind, W> sliding(features_);
    const Look found = sliding.look();
    first = sliding.time();
    return found;
  }
  COLLIDED_HD Cubic<3 * W> volume() const {
    const MovingProduct<W> bc(features_.d[1], features_.d[2]);
    const Vec3<Integer<W>>(&a)[2] = features_.d[0].p;
    return {{wide_dot(a[0], bc.c[0]), wide_dot(a[0], bc.c[1]) + wide_dot(a[1], bc.c[0]),
             wide_dot(a[0], bc.c[2]) + wide_dot(a[1], bc.c[1]), wide_dot(a[1], bc.c[2])}};
  }

  Differences<kind, W> features_;
};

/// use(decision) of the size that the coordinates need; false: they need more than there is.
template <ContactKind kind, class Use>
COLLIDED_HD bool with_decision(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const Use& use) {
  Unit unit;
  unit.see(start);
  unit.see(end);
  if (unit.fits<1>())
    use(Decision<kind, 1>(unit, start, end));
  else if (unit.fits<2>())
    use(Decision<kind, 2>(unit, start, end));
  else
    return false;
  return true;
}

template <ContactKind kind>
COLLIDED_HD Verdict decide(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4]) {
  Verdict verdict;
  with_decision<kind>(start, end, [&](const auto& decision) { verdict = decision.verdict(); });
  return verdict;
}
COLLIDED_HD inline Verdict decide(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4]) {
  return kind == ContactKind::kVertexTriangle ? decide<ContactKind::kVertexTriangle>(start, end)
                                              : decide<ContactKind::kEdgeEdge>(start, end);
}

// Of features that do not meet before `from`, a time in [0, 1]: much is known of them if they meet soon after it.

/// kBetween, where they do and nothing is just so; else left open.
template <ContactKind kind>
COLLIDED_HD Verdict decide_soon(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], double from) {
  const SoonMeeting<kind> soon(start, end);
  uint64_t k = 0;
  if (!soon.find_root(from, k) || !soon.meet_at(k)) return {};
  return {Outcome::kBetween, time_of(k)};
}
/// As decide(), but faster where they do.
template <ContactKind kind>
COLLIDED_HD Verdict decide_from(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], double from) {
  uint64_t k = 0;
  const bool is_known = from > 0 && SoonMeeting<kind>(start, end).find_root(from, k);
  Verdict verdict;
  with_decision<kind>(start, end, [&](const auto& decision) {
    verdict = is_known && decision.meet_at(k) ? Verdict{Outcome::kBetween, time_of(k)} : decision.verdict();
  });
  return verdict;
}

/// kAtStart: they touch.
template <ContactKind kind>
COLLIDED_HD Outcome decide_at_rest(const Vec3<double> (&p)[4]) {
  Unit unit;
  unit.see(p);
  const auto outcome = [](bool touches) { return touches ? Outcome::kAtStart : Outcome::kApart; };
  if (unit.fits<1>()) return outcome(touch(Differences<kind, 1>(unit, p, p), 0));
  if (unit.fits<2>()) return outcome(touch(Differences<kind, 2>(unit, p, p), 0));
  return Outcome::kOpen;
}
COLLIDED_HD inline Outcome decide_at_rest(ContactKind kind, const Vec3<double> (&p)[4]) {
  return kind == ContactKind::kVertexTriangle ? decide_at_rest<ContactKind::kVertexTriangle>(p)
                                              : decide_at_rest<ContactKind::kEdgeEdge>(p);
}

}  // namespace collided::exact::fixed
