#pragma once
// Pairs of features of a case as queries for the judge.

#include "tests/support/brute_force.hpp"
#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {

/// Ids are scene-wide.
class CaseQueries {
 public:
  explicit CaseQueries(const Case& c);

  const Features& features() const { return features_; }
  const Positions& end() const { return end_; }  ///< of all vertices at t = 1

  /// `vertices`: v a b c, or a0 a1 b0 b1.
  Query of_vertices(QueryKind kind, const std::array<uint32_t, 4>& vertices) const;
  /// The vertex and the triangle, or the two edges.
  Query of_pair(QueryKind kind, PairKey pair) const;
  std::array<uint32_t, 4> vertices_of(QueryKind kind, PairKey pair) const;

 private:
  const Features features_;
  const Positions start_, end_;
};

}  // namespace collided::test
