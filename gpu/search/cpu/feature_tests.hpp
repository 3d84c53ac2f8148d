#pragma once
// The elementary box tests of pairs of triangles on CPU cores: the boxes of a triangle's features side by side, so that
// one feature meets all of another triangle's at once. They are those of the records (boxes/records.hpp).

#include "gpu/search/cpu/lanes.hpp"
#include "gpu/search/loose_elements.hpp"

namespace collided {

/// What the tests need of a triangle.
struct FeatureBoxes {
  BoxLanes<float> edges;    ///< 0-1, 1-2, 2-0, then the triangle
  BoxLanes<float> corners;  ///< 0, 1, 2, then 2 again
  Lanes<uint32_t> vertex;   ///< of each corner, likewise
  uint32_t edge[3];
  uint32_t owned;  ///< to be tested: bits 0-2: corner 0, 1, 2; bits 3-5: edge 0-1, 1-2, 2-0; from kFirstRoleBit: role

  /// `corner`: the box of each corner's path; `own`: what is to be tested.
  FeatureBoxes(const Box<float> (&corner)[3], const Vec3<uint32_t>& v, const Vec3<uint32_t>& e, uint32_t own,
               ElementRole role = ElementRole::kTriangle)
      : vertex{v.x, v.y, v.z, v.z}, edge{e.x, e.y, e.z}, owned(own | static_cast<uint32_t>(role) << kFirstRoleBit) {
    for (int k = 0; k < 4; ++k) {
      const int here = k < 3 ? k : 2, next = k < 2 ? k + 1 : 0;
      corners.set(k, corner[here]);
      edges.set(k, k < 3 ? join(corner[k], corner[next]) : join(edges.get(0), corner[2]));
    }
  }
  ElementRole role() const { return static_cast<ElementRole>(owned >> kFirstRoleBit); }

 private:
  static constexpr int kFirstRoleBit = 8;  // four bits from 3 on meet lanes
};

/// A triangle that is tested against several others. Tests have the numbers of search/elementary_numbers.hpp.
class FeatureRow {
 public:
  explicit FeatureRow(const FeatureBoxes& a) : triangle_(a.edges.spread(3)) {
    for (int k = 0; k < 3; ++k) {
      fill_lanes<uint32_t>(vertex_[k], a.vertex[k]);
      if ((a.owned >> k & 1u) != 0) corner_[corners_++] = {a.corners.spread(k), k};
      if ((a.owned >> (3 + k) & 1u) != 0) edge_[edges_++] = {a.edges.spread(k), edge_edge_test(k, 0)};
    }
  }

  /// One bit for each test whose features share no vertex and whose boxes are not apart.
  uint32_t tests(const FeatureBoxes& b) const {
    uint32_t tests = (meeting_lanes(triangle_, b.corners) & b.owned & 7u) << 3;
    for (int i = 0; i < corners_; ++i) tests |= (meeting_lanes(corner_[i].box, b.edges) >> 3) << corner_[i].test;
    for (int i = 0; i < edges_; ++i) tests |= (meeting_lanes(edge_[i].box, b.edges) & b.owned >> 3) << edge_[i].test;
    return tests & ~tests_within(b);
  }

 private:
  /// Tests whose features share a vertex.
  uint32_t tests_within(const FeatureBoxes& b) const {
    const auto same0 = vertex_[0] == b.vertex, same1 = vertex_[1] == b.vertex, same2 = vertex_[2] == b.vertex;
    if (lane_bits(same0 | same1 | same2) == 0) return 0;
    const uint32_t same[3] = {lane_bits(same0) & 7u, lane_bits(same1) & 7u, lane_bits(same2) & 7u};
    uint32_t tests = (same[0] | same[1] | same[2]) << 3;
    for (int k = 0; k < 3; ++k) {
      if (same[k] != 0) tests |= 1u << k;
      const uint32_t ends = same[k] | same[k < 2 ? k + 1 : 0];
      tests |= (ends | ends >> 1 | (ends << 2 & 4u)) << edge_edge_test(k, 0);
    }
    return tests;
  }

  struct Owned {
    BoxLanes<float> box;
    int test;  ///< the first of its tests
  };
  BoxLanes<float> triangle_;
  Lanes<uint32_t> vertex_[3];
  Owned corner_[3], edge_[3];
  int corners_ = 0, edges_ = 0;
};

/// Those of a triangle, from what its tests know (search/elementary.hpp).
template <class Tests>
FeatureBoxes feature_boxes_of(const Tests& tests, uint32_t triangle) {
  return {{tests.corner_box(triangle, 0), tests.corner_box(triangle, 1), tests.corner_box(triangle, 2)},
          tests.vertices_of(triangle),
          tests.edges_of(triangle),
          tests.tested_of(triangle),
          tests.role(triangle)};
}

}  // namespace collided
