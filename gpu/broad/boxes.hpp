#pragma once
// Section 3: the bounding box of every triangle: over the step for CCD, of the frame for DCD, inflated by half
// the thickness, rounded outward to float.

#include <limits>

#include "gpu/math/lattice.hpp"

namespace collided {

using Triangle = Vec3<uint32_t>;

/// A corner of a triangle with all that the tests of features need, in one place: reading it takes two wide loads,
/// where looking it up would take several scattered ones.
template <class Real>
struct alignas(16) CornerRecord {
  Vec3<Real> start;
  uint32_t vertex;  ///< kOwned: the triangle owns the vertex
  alignas(16) Vec3<Real> end;
  uint32_t edge;  ///< to the next corner; kOwned likewise

  static constexpr uint32_t kOwned = 1u << 31;
  COLLIDED_HD uint32_t vertex_id() const { return vertex & ~kOwned; }
  COLLIDED_HD uint32_t edge_id() const { return edge & ~kOwned; }
  /// Box of the corner's path.
  COLLIDED_HD Box<Real> swept() const { return join(Box<Real>{start, start}, Box<Real>{end, end}); }
};

/// The box of an edge's path, and its vertices.
template <class Real>
struct alignas(16) EdgeRecord {
  Vec3<Real> lo;
  uint32_t from;
  alignas(16) Vec3<Real> hi;
  uint32_t to;

  COLLIDED_HD Box<Real> swept() const { return {lo, hi}; }
};

/// What the tests of features need of the triangles. All first corners lie side by side, then all second ones, and so
/// on, so that threads that write those of neighbouring triangles write neighbouring memory.
template <class Real>
struct TriangleRecords {
  CornerRecord<Real>* corners;
  EdgeRecord<Real>* edges;  ///< from each corner to the next
  uint32_t triangles;       ///< below 2^30

  COLLIDED_HD CornerRecord<Real>& corner(uint32_t triangle, int k) const { return corners[at(triangle, k)]; }
  COLLIDED_HD EdgeRecord<Real>& edge(uint32_t triangle, int k) const { return edges[at(triangle, k)]; }

 private:
  COLLIDED_HD uint32_t at(uint32_t triangle, int k) const { return static_cast<uint32_t>(k) * triangles + triangle; }
};

template <class Real>
struct BoxTriangles {
  Motion<Real> motion;
  Span<const Triangle> triangles;
  Span<const Triangle> edges;  ///< empty: the scene needs none
  Span<const uint8_t> owned;   ///< bits 0-2: corner 0, 1, 2; bits 3-5: edge 0-1, 1-2, 2-0
  uint64_t first;
  Span<Box<float>> boxes;
  TriangleRecords<Real> records;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Triangle t = triangles[first + i];
    boxes[first + i] = outward_float(motion.triangle_box(t.x, t.y, t.z));
    const Triangle e = edges.empty() ? Triangle{0, 0, 0} : edges[first + i];
    const uint32_t own = owned[first + i];
    const CornerRecord<Real> a = corner(t.x, e.x, own), b = corner(t.y, e.y, own >> 1), c = corner(t.z, e.z, own >> 2);
    const CornerRecord<Real> corners[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      records.corner(static_cast<uint32_t>(first + i), k) = corners[k];
      records.edge(static_cast<uint32_t>(first + i), k) = edge(corners[k], corners[k < 2 ? k + 1 : 0]);
    }
  }

 private:
  /// Bit 0 of `own`: owns the vertex; bit 3: owns the edge.
  COLLIDED_HD CornerRecord<Real> corner(uint32_t v, uint32_t e, uint32_t own) const {
    return {motion.start[v], v | (own & 1u) << 31, motion.end[v], e | (own >> 3 & 1u) << 31};
  }
  COLLIDED_HD static EdgeRecord<Real> edge(const CornerRecord<Real>& from, const CornerRecord<Real>& to) {
    const Box<Real> box = join(from.swept(), to.swept());
    return {box.lo, from.vertex_id(), box.hi, to.vertex_id()};
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
