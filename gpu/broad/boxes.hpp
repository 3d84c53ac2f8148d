#pragma once
// Section 3: the bounding box of every triangle: over the step for CCD, of the frame for DCD, inflated by half
// the thickness, rounded outward to float.

#include <limits>

#include "gpu/math/lattice.hpp"

namespace collided {

using Triangle = Vec3<uint32_t>;

/// A triangle with all that the tests of its features need, in one place: a pair's two records are read at once,
/// where looking up vertices would take a dozen scattered reads.
template <class Real>
struct alignas(16) TriangleRecord {
  Vec3<Real> start[3], end[3];
  uint32_t vertex[3];  ///< kOwned: the triangle owns the vertex
  uint32_t edge[3];    ///< of corners 0-1, 1-2, 2-0; kOwned likewise

  static constexpr uint32_t kOwned = 1u << 31;
  COLLIDED_HD uint32_t vertex_id(int k) const { return vertex[k] & ~kOwned; }
  COLLIDED_HD uint32_t edge_id(int k) const { return edge[k] & ~kOwned; }
};

template <class Real>
struct BoxTriangles {
  Motion<Real> motion;
  Span<const Triangle> triangles;
  Span<const Triangle> edges;  ///< empty: the scene needs none
  Span<const uint8_t> owned;   ///< bits 0-2: corner 0, 1, 2; bits 3-5: edge 0-1, 1-2, 2-0
  uint64_t first;
  Span<Box<float>> boxes;
  Span<TriangleRecord<Real>> records;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Triangle t = triangles[first + i];
    boxes[first + i] = outward_float(motion.triangle_box(t.x, t.y, t.z));
    const uint32_t v[3] = {t.x, t.y, t.z};
    TriangleRecord<Real> record;
    for (int k = 0; k < 3; ++k) {
      record.start[k] = motion.start[v[k]];
      record.end[k] = motion.end[v[k]];
      record.vertex[k] = v[k] | (owned[first + i] >> k & 1u) << 31;
    }
    const Triangle e = edges.empty() ? Triangle{0, 0, 0} : edges[first + i];
    const uint32_t ids[3] = {e.x, e.y, e.z};
    for (int k = 0; k < 3; ++k) record.edge[k] = ids[k] | (owned[first + i] >> (3 + k) & 1u) << 31;
    records[first + i] = record;
  }
};

struct BoxOf {
  Span<const Box<float>> boxes;
  COLLIDED_HD Box<float> operator()(uint64_t i) const { return boxes[i]; }
};
struct JoinBoxes {
  COLLIDED_HD Box<float> operator()(const Box<float>& a, const Box<float>& b) const { return join(a, b); }
};
inline Box<float> empty_box() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
}

}  // namespace collided
