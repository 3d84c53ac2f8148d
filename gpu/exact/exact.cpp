#include "gpu/exact/exact.hpp"

#include "gpu/exact/features.hpp"
#include "gpu/exact/fixed/decide.hpp"
#include "gpu/exact/fixed/within.hpp"

namespace collided {
namespace {

using exact::fixed::Outcome;

template <ContactKind kind>
Outcome decide_within(const Vec3<double> (&p)[4], double thickness) {
  exact::fixed::Unit unit;
  unit.see(p);
  unit.see(thickness);
  const auto outcome = [&]<int W>() {
    const exact::fixed::Differences<kind, W> features(unit, p, p);
    const bool is_within = exact::fixed::Within<kind, W>(features, unit.count<W>(thickness)).run();
    return is_within ? Outcome::kAtStart : Outcome::kApart;
  };
  if (unit.fits<1>()) return outcome.template operator()<1>();
  if (unit.fits<2>()) return outcome.template operator()<2>();
  return Outcome::kOpen;
}

Outcome decide_at_rest(ContactKind kind, const Vec3<double> (&p)[4], double thickness) {
  if (thickness == 0) return exact::fixed::decide_at_rest(kind, p);
  return kind == ContactKind::kVertexTriangle ? decide_within<ContactKind::kVertexTriangle>(p, thickness)
                                              : decide_within<ContactKind::kEdgeEdge>(p, thickness);
}

}  // namespace

// First integers of fixed size, then, for what they leave open, integers of any size.
ExactImpact exact_ccd(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                      double thickness) {
  if (thickness == 0) {
    const exact::fixed::Verdict verdict = exact::fixed::decide(kind, start, end);
    if (verdict.outcome != Outcome::kOpen)
      return {verdict.outcome != Outcome::kApart, verdict.toi, verdict.outcome == Outcome::kAtStart};
  } else if (decide_at_rest(kind, start, thickness) == Outcome::kAtStart) {
    return {true, 0, true};
  }
  return exact::first_impact(exact::contact_in_motion(kind, start, end, thickness));
}

bool exact_proximity(ContactKind kind, const Vec3<double> (&p)[4], double thickness) {
  const Outcome outcome = decide_at_rest(kind, p, thickness);
  if (outcome != Outcome::kOpen) return outcome == Outcome::kAtStart;
  return exact::holds_at_start(exact::contact_of(kind, exact::at_rest(p, thickness)));
}

}  // namespace collided
