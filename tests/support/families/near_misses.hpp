#pragma once
// Features that slide past each other, or move in one plane, and come within 1e-16 to 1e-5 of contact.

#include "tests/support/families/query_families.hpp"

namespace collided::test {

enum class NearMissFamily {
  kCoplanar,    ///< all eight points are in one plane, but for rounding
  kNearPlanar,  ///< the same, and off it by 1e-17 to 1e-3
  kSliding,     ///< the first feature moves past the second, without turning
  kGliding      ///< the same, past a triangle, or an edge, that is parallel to the motion
};
inline constexpr NearMissFamily kNearMissFamilies[] = {NearMissFamily::kCoplanar, NearMissFamily::kNearPlanar,
                                                       NearMissFamily::kSliding, NearMissFamily::kGliding};

std::string name_of(NearMissFamily family);

/// A query whose features come about that close to `thickness`; some come closer.
Query near_miss(NearMissFamily family, QueryKind kind, double thickness, Random& random);

}  // namespace collided::test
