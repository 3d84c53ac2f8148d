#pragma once
// Section 3: the bounding box of every triangle: over the step for CCD, of the frame for DCD, inflated by half
// the thickness and by how far its mesh may be from its path, rounded outward to float.

#include <limits>

#include "gpu/base/deviations.hpp"
#include "gpu/base/lattice.hpp"
#include "gpu/base/worlds.hpp"
#include "gpu/exec/counted.hpp"

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

/// An edge's inflated box, and its vertices.
template <class Real>
struct alignas(16) EdgeRecord {
  Vec3<Real> lo;
  uint32_t from;
  alignas(16) Vec3<Real> hi;
  uint32_t to;

  COLLIDED_HD Box<Real> box() const { return {lo, hi}; }
};

/// An inflation and a margin, rounded up; exact where there is no margin.
template <class Real>
COLLIDED_HD Real widened(Real inflation, Real margin) {
  return margin > 0 ? next_up(inflation + margin) : inflation;
}

template <class Real>
struct TriangleRecord {
  CornerRecord<Real> corner[3];
  EdgeRecord<Real> edge[3];  ///< from each corner to the next
};

/// One item for each kGroupSize triangles. Their records are put together in the group's memory first, and then written
/// side by side: a thread that wrote its own would leave most of each memory transaction empty.
template <class Real>
struct BoxTriangles {
  static constexpr uint32_t kGroupSize = 128;
  struct Shared {
    TriangleRecord<Real> record[kGroupSize];
  };

  Motion<Real> motion;
  Deviations deviations;
  WorldTable<Triangle> triangles;
  WorldTable<Triangle> edges;  ///< empty: the scene needs none
  Span<const uint8_t> owned;   ///< bits 0-2: corner 0, 1, 2; bits 3-5: edge 0-1, 1-2, 2-0
  uint64_t first, count;       ///< of the triangles to box
  Span<Box<float>> boxes;
  Span<TriangleRecord<Real>> records;
  Span<Real> inflations;  ///< empty: that of `motion` is each triangle's
  Real margin = 0;        ///< added to all inflations
  SteppedWorlds stepped = {};

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    const uint64_t begin = first + i * kGroupSize;
    const uint32_t size = static_cast<uint32_t>(min(uint64_t{kGroupSize}, first + count - begin));
    for (uint32_t k = group.rank; k < size; k += group.size) {
      const Triangle t = triangles[begin + k];
      const Real inflation = widened(deviations.inflation(motion.inflation, t.x), margin);
      const TriangleRecord<Real> made = shared.record[k] = record(t, begin + k, inflation);
      const Box<float> box = outward_float(join(made.edge[0].box(), made.edge[1].box()));
      boxes[begin + k] = stepped.has(begin + k) ? box : no_box();
      if (!inflations.empty()) inflations[begin + k] = inflation;
    }
    group.sync();
    group.copy(&records[begin], shared.record, size);
  }

 private:
  COLLIDED_HD TriangleRecord<Real> record(const Triangle& t, uint64_t triangle, Real inflation) const {
    const Triangle e = edges.empty() ? Triangle{0, 0, 0} : edges[triangle];
    const uint32_t own = owned[triangle];
    const CornerRecord<Real> a = corner(t.x, e.x, own), b = corner(t.y, e.y, own >> 1), c = corner(t.z, e.z, own >> 2);
    return {{a, b, c}, {edge(a, b, inflation), edge(b, c, inflation), edge(c, a, inflation)}};
  }
  /// Bit 0 of `own`: owns the vertex; bit 3: owns the edge.
  COLLIDED_HD CornerRecord<Real> corner(uint32_t v, uint32_t e, uint32_t own) const {
    return {motion.start[v], v | (own & 1u) << 31, motion.end[v], e | (own >> 3 & 1u) << 31};
  }
  COLLIDED_HD static EdgeRecord<Real> edge(const CornerRecord<Real>& from, const CornerRecord<Real>& to,
                                           Real inflation) {
    const Box<Real> box = inflate(join(from.swept(), to.swept()), inflation);
    return {box.lo, from.vertex_id(), box.hi, to.vertex_id()};
  }
};

struct BoxOf {
  Span<const Box<float>> boxes;
  COLLIDED_HD Box<float> operator()(uint64_t i) const { return boxes[i]; }
};
struct JoinBoxes {
  template <class Real>
  COLLIDED_HD Box<Real> operator()(const Box<Real>& a, const Box<Real>& b) const {
    return join(a, b);
  }
};
template <class Real = float>
Box<Real> empty_box() {
  constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
  return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
}

}  // namespace collided
