#include "gpu/exact/exact.hpp"

#include <utility>

#include "gpu/exact/features.hpp"
#include "gpu/exact/fixed/decide.hpp"
#include "gpu/exact/fixed/separation.hpp"
#include "gpu/exact/fixed/within.hpp"

namespace collided {
namespace {

using exact::fixed::Outcome;

/// Decides features at rest, or tells what is simple of those that move: if they are in contact at the start, or apart
/// until the end.
template <ContactKind kind, int W>
class Within {
 public:
  Within(const exact::fixed::Unit& unit, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
         const ContactDistance& limit)
      : features_(unit, start, end), limit_(unit.count<W>(limit)) {}

  Outcome at_rest() const { return touches(features_) ? Outcome::kAtStart : Outcome::kApart; }
  Outcome in_motion() const {
    using exact::fixed::Apart;
    if (touches(features_)) return Outcome::kAtStart;
    const Apart apart = exact::fixed::Separation<kind, W>(features_, limit_).look();
    if (apart == Apart::kPerhaps) return Outcome::kOpen;
    return apart == Apart::kBeforeEnd && touches(reversed()) ? Outcome::kAtEnd : Outcome::kApart;
  }

 private:
  using Features = exact::fixed::Differences<kind, W>;

  bool touches(const Features& features) const { return exact::fixed::Within<kind, W>(features, limit_).run(); }
  Features reversed() const {
    Features features = features_;
    for (auto& d : features.d) std::swap(d.p[0], d.p[1]);
    return features;
  }

  Features features_;
  exact::fixed::Integer<W> limit_;
};

/// use(within) of the size that the numbers need; kOpen if they need more than there is.
template <ContactKind kind, class Use>
Outcome with_size(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const ContactDistance& limit,
                  const Use& use) {
  exact::fixed::Unit unit;
  unit.see(start);
  unit.see(end);
  unit.see(limit);
  if (unit.fits<1>()) return use(Within<kind, 1>(unit, start, end, limit));
  if (unit.fits<2>()) return use(Within<kind, 2>(unit, start, end, limit));
  return Outcome::kOpen;
}
template <class Use>
Outcome with_size(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                  const ContactDistance& limit, const Use& use) {
  return kind == ContactKind::kVertexTriangle ? with_size<ContactKind::kVertexTriangle>(start, end, limit, use)
                                              : with_size<ContactKind::kEdgeEdge>(start, end, limit, use);
}

Outcome decide_at_rest(ContactKind kind, const Vec3<double> (&p)[4], const ContactDistance& limit) {
  if (limit.is_zero()) return exact::fixed::decide_at_rest(kind, p);
  return with_size(kind, p, p, limit, [](const auto& within) { return within.at_rest(); });
}

/// True if an axis keeps the features apart all along: a difference is not above a double unless its rounding is.
bool are_apart_along_an_axis(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                             const ContactDistance& limit) {
  const double above = limit.above();
  const size_t first = kind == ContactKind::kVertexTriangle ? 1 : 2;
  const auto are_apart = [&](double Vec3<double>::*axis, double side) {
    for (size_t i = 0; i < first; ++i)
      for (size_t j = first; j < 4; ++j)
        if (!(side * (start[i].*axis - start[j].*axis) > above && side * (end[i].*axis - end[j].*axis) > above))
          return false;
    return true;
  };
  for (const auto axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z})
    if (are_apart(axis, 1) || are_apart(axis, -1)) return true;
  return false;
}

/// Decides the simple cases with a limit above 0; leaves the others open.
Outcome decide_within(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                      const ContactDistance& limit) {
  if (are_apart_along_an_axis(kind, start, end, limit)) return Outcome::kApart;
  return with_size(kind, start, end, limit, [](const auto& within) { return within.in_motion(); });
}

}  // namespace

// First integers of fixed size, then, for what they leave open, integers of any size.
ExactImpact exact_ccd(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                      const ContactDistance& limit) {
  exact::fixed::Verdict verdict;
  if (limit.is_zero()) {
    verdict = exact::fixed::decide(kind, start, end);
  } else {
    verdict.outcome = decide_within(kind, start, end, limit);
    if (verdict.outcome == Outcome::kAtStart) verdict.toi = 0;
  }
  if (verdict.outcome != Outcome::kOpen)
    return {verdict.outcome != Outcome::kApart, verdict.toi, verdict.outcome == Outcome::kAtStart};
  return exact::first_impact(exact::contact_in_motion(kind, start, end, limit));
}

bool exact_proximity(ContactKind kind, const Vec3<double> (&p)[4], const ContactDistance& limit) {
  const Outcome outcome = decide_at_rest(kind, p, limit);
  if (outcome != Outcome::kOpen) return outcome == Outcome::kAtStart;
  return exact::holds_at_start(exact::contact_at_rest(kind, p, limit));
}

}  // namespace collided
