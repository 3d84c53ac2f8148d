#pragma once
// Which pairs of features a spec leaves out, by the definitions: the edges between two vertices are counted breadth
// first, distances at rest are the exact judge's.

#include "tests/support/case_queries.hpp"

namespace collided::test {

class Exclusions {
 public:
  /// `rest` is the first frame, rounded to the scene's scalar type.
  Exclusions(const Case& rest, const SceneSpec& spec);

  /// Ids are scene-wide.
  bool has(ContactKind kind, uint32_t first, uint32_t second) const;
  /// The pairs that are left.
  PairSet left_of(ContactKind kind, const PairSet& pairs) const;
  /// The contacts that are left, with all that the answer tells of them.
  ContactSet left_of(ContactKind kind, const ContactSet& contacts) const;

 private:
  std::vector<uint32_t> vertices_of(ContactKind kind, uint32_t id, bool is_first) const;
  bool are_connected(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b, uint32_t edges) const;
  bool are_close_at_rest(ContactKind kind, PairKey pair) const;
  void count_edges();

  const SceneSpec spec_;
  const CaseQueries rest_;
  std::vector<std::vector<uint8_t>> edges_between_;  ///< of vertices of one mesh; kMaxRings + 1: more than kMaxRings
};

/// Which meshes' pairs of triangles are wanted at all: groups, masks, static meshes, pairs of meshes.
bool may_touch(const SceneSpec& spec, uint32_t mesh, uint32_t other);

/// The spec without any exclusion but that of static meshes: the full model.
SceneSpec full_model(SceneSpec spec);

}  // namespace collided::test
