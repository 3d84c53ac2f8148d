#include "gpu/exact/exact.hpp"

#include "gpu/exact/features.hpp"
#include "gpu/exact/fixed/decide.hpp"

namespace collided {

using exact::fixed::Outcome;

// First integers of fixed size, then, for what they leave open, integers of any size.
ExactImpact exact_ccd(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                      double thickness) {
  if (thickness == 0) {
    const exact::fixed::Verdict verdict = exact::fixed::decide(kind, start, end);
    if (verdict.outcome != Outcome::kOpen)
      return {verdict.outcome != Outcome::kApart, verdict.toi, verdict.outcome == Outcome::kAtStart};
  }
  return exact::first_impact(exact::contact_of(kind, exact::in_motion(start, end, thickness)));
}

bool exact_proximity(ContactKind kind, const Vec3<double> (&p)[4], double thickness) {
  if (thickness == 0) {
    const Outcome outcome = exact::fixed::decide_at_rest(kind, p);
    if (outcome != Outcome::kOpen) return outcome == Outcome::kAtStart;
  }
  return exact::holds_at_start(exact::contact_of(kind, exact::at_rest(p, thickness)));
}

}  // namespace collided
