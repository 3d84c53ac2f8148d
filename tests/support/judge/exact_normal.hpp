#pragma once
// How a direction lies between two features, in rational arithmetic.

#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

/// `gap`: the least n . x of the first feature's points less the most of the second's, so that with a unit n the
/// distance is at least that, and equal for the one n that points from the closest point of the second feature to that
/// of the first.
struct ExactNormal {
  mpq_class squared_length, gap;
};

/// At time t of the query, 0 <= t <= 1.
ExactNormal judge_normal(const Query& query, const mpq_class& t, const std::array<float, 3>& n);

}  // namespace collided::test
