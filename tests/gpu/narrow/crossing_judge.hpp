#pragma once
// Finds the edges of a scene that go through triangles, in exact arithmetic on all pairs, without the engine.

#include <map>
#include <optional>
#include <span>

#include "tests/support/case_queries.hpp"

namespace collided::test {

/// A case as one scene, where its meshes end: its features by scene-wide ids.
struct Surface {
  explicit Surface(const Case& c);

  bool is_loose(size_t t) const { return topology.triangles[t][1] == topology.triangles[t][2]; }
  bool share_vertex(size_t e, size_t t) const;

  Topology topology;
  Positions positions;
};

struct JudgedCrossings {
  std::vector<PairKey> sure;  ///< no determinant that decides is 0; ascending
  std::vector<PairKey> tied;  ///< one is, and the order of ids makes it a crossing; ascending

  std::vector<PairKey> all() const;  ///< ascending
};

/// True if the edge goes through the triangle, with which it shares no vertex; no answer where a determinant that
/// decides is 0.
std::optional<bool> goes_through(const std::array<Vec3d, 2>& edge, const std::array<Vec3d, 3>& triangle);

/// All pairs of an edge and a triangle with no common vertex. Ties are decided by the engine's own exact arithmetic,
/// which tests/gpu/exact judges.
JudgedCrossings judge_crossings(const Surface& surface);

/// Each pair of triangles one of which has an edge that goes through the other, and how many such edges the two have:
/// the ends of their part of the contour. `crossings` are edges and triangles.
std::map<PairKey, uint32_t> contour_ends(std::span<const std::array<uint32_t, 2>> crossings, const Topology& topology);

}  // namespace collided::test
