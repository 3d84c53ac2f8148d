#pragma once
// What the exact judge says of the pairs of a case, by scene-wide feature ids.

#include <map>

#include "tests/support/case_queries.hpp"

namespace collided::test {

/// The pairs in contact and when; in DCD the times say nothing.
using Truth = std::map<PairKey, ExactImpact>;

class CaseJudge {
 public:
  /// The case has to be rounded to the scene's scalar type already. Half thicknesses are those of its meshes.
  CaseJudge(const Case& c, Mode mode, double thickness);

  using Pairs = std::span<const std::array<uint32_t, 2>>;
  Truth vertex_triangle(const Pairs& pairs) const { return judge(QueryKind::kVertexTriangle, pairs); }
  Truth edge_edge(const Pairs& pairs) const { return judge(QueryKind::kEdgeEdge, pairs); }
  /// Of all pairs of triangles: those that share a point at t = 1. Of two with one common corner, the side opposite to
  /// it of one meets the other; those with two are never among them. Ascending.
  std::vector<PairKey> triangles() const;

 private:
  Truth judge(QueryKind kind, const Pairs& pairs) const;
  ExactImpact judge(const Query& query, const Thickness& thickness) const;

  CaseQueries queries_;
  std::vector<double> halves_;  ///< of each mesh
  Mode mode_;
  double thickness_;
};

std::vector<PairKey> keys_of(const ContactSet& contacts);
std::vector<PairKey> keys_of(const Truth& truth);

/// A soup on_integers().
Case lattice(uint32_t seed, uint32_t count, double side);

/// A sheet of n x n cells whose vertices are moved at random: it goes through itself, neighbours through each other.
Case crumpled(uint32_t seed, uint32_t n, double by);

/// "CANDIDATES" to "EXACT".
std::string level_name(Accuracy accuracy);

}  // namespace collided::test
