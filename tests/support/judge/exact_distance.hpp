#pragma once
// Contact at a distance, for the other parts of the judge.

#include "tests/support/judge/exact_geometry.hpp"
#include "tests/support/judge/exact_root.hpp"

namespace collided::test {

/// The first time at which the distance is <= the query's thickness, which may be 0.
ExactImpact first_time_within(const ExactQuery& q);

/// A hit at this time.
ExactImpact impact_at(Root& time);

}  // namespace collided::test
