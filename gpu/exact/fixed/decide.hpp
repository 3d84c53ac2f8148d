#pragma once
// The decisions of exact.hpp, without thickness, for what most queries are: coordinates whose exponents lie together,
// and features that touch at an end of the step, or are in one plane at most once between. The rest is left open.

#include "gpu/exact/fixed/crossing.hpp"
#include "gpu/exact/fixed/touching.hpp"

namespace collided::exact::fixed {

/// `kOpen`: not decided.
enum class Outcome : uint8_t { kOpen, kApart, kAtStart, kBetween, kAtEnd };

struct Verdict {
  Outcome outcome = Outcome::kOpen;
  double toi = 1;  ///< as ExactImpact::toi
};

template <ContactKind kind, int W>
class Decision {
 public:
  COLLIDED_HD Decision(const Unit& unit, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4])
      : start_(differences_of<kind, W>(unit, start)), end_(differences_of<kind, W>(unit, end)) {}

  COLLIDED_HD Verdict verdict() const {
    const Cubic<3 * W> f = volume();
    const int at_start = f.c[0].sign(), at_end = f.c[3].sign(), changes = sign_changes(f);
    if (at_start == 0 && touch<kind>(start_)) return {Outcome::kAtStart, 0};
    if (changes > 1 || (changes == 0 && vanishes(f))) return {};
    if (changes == 1) {
      const uint64_t k = RootSearch(f, first_sign(f)).run();
      const bool is_only_root = (at_start != 0 || k > 0) && (at_end != 0 || k + 1 < kOne);
      const auto answer = Crossing<kind, W>(start_, end_, k, is_only_root).answer();
      if (answer == Crossing<kind, W>::Answer::kOpen) return {};
      if (answer == Crossing<kind, W>::Answer::kMeet) return {Outcome::kBetween, time_of(k)};
    }
    return {at_end == 0 && touch<kind>(end_) ? Outcome::kAtEnd : Outcome::kApart, 1};
  }

 private:
  COLLIDED_HD Cubic<3 * W> volume() const {
    const auto &p = start_.d, &q = end_.d;
    const auto c0 = wide_cross(p[1], p[2]), c1 = wide_cross(p[1], q[2]) + wide_cross(q[1], p[2]),
               c2 = wide_cross(q[1], q[2]);
    return {{wide_dot(p[0], c0), wide_dot(p[0], c1) + wide_dot(q[0], c0), wide_dot(p[0], c2) + wide_dot(q[0], c1),
             wide_dot(q[0], c2)}};
  }
  COLLIDED_HD static bool vanishes(const Cubic<3 * W>& f) { return first_sign(f) == 0; }
  COLLIDED_HD static int first_sign(const Cubic<3 * W>& f) {
    for (const Integer<3 * W>& x : f.c)
      if (const int sign = x.sign()) return sign;
    return 0;
  }

  Differences<W> start_, end_;
};

template <ContactKind kind>
COLLIDED_HD Verdict decide(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4]) {
  Unit unit;
  unit.see(start);
  unit.see(end);
  if (unit.fits<1>()) return Decision<kind, 1>(unit, start, end).verdict();
  if (unit.fits<2>()) return Decision<kind, 2>(unit, start, end).verdict();
  return {};
}
COLLIDED_HD inline Verdict decide(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4]) {
  return kind == ContactKind::kVertexTriangle ? decide<ContactKind::kVertexTriangle>(start, end)
                                              : decide<ContactKind::kEdgeEdge>(start, end);
}

/// kAtStart: they touch.
template <ContactKind kind>
COLLIDED_HD Outcome decide_at_rest(const Vec3<double> (&p)[4]) {
  Unit unit;
  unit.see(p);
  const auto outcome = [](bool touches) { return touches ? Outcome::kAtStart : Outcome::kApart; };
  if (unit.fits<1>()) return outcome(touch<kind>(differences_of<kind, 1>(unit, p)));
  if (unit.fits<2>()) return outcome(touch<kind>(differences_of<kind, 2>(unit, p)));
  return Outcome::kOpen;
}
COLLIDED_HD inline Outcome decide_at_rest(ContactKind kind, const Vec3<double> (&p)[4]) {
  return kind == ContactKind::kVertexTriangle ? decide_at_rest<ContactKind::kVertexTriangle>(p)
                                              : decide_at_rest<ContactKind::kEdgeEdge>(p);
}

}  // namespace collided::exact::fixed
