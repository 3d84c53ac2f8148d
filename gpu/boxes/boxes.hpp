#pragma once
// Section 3: the bounding box of every triangle: over the step for CCD, of the frame for DCD, inflated by half
// the thickness, its mesh's own half thickness, and how far its mesh may be from its path, rounded outward to float.

#include <limits>

#include "gpu/base/half_thickness.hpp"
#include "gpu/base/lattice.hpp"
#include "gpu/base/worlds.hpp"
#include "gpu/boxes/records.hpp"
#include "gpu/exec/counted.hpp"

namespace collided {

using Triangle = Vec3<uint32_t>;

/// An inflation and a margin, rounded up; exact where there is no margin.
template <class Real>
COLLIDED_HD Real widened(Real inflation, Real margin) {
  return margin > 0 ? next_up(inflation + margin) : inflation;
}

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
  Span<Path<Real>> paths;  ///< empty: records have them
  Span<Real> inflations;   ///< empty: that of `motion` is each triangle's
  Real margin = 0;         ///< added to all inflations
  SteppedWorlds stepped = {};
  HalfThicknesses halves = {};

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    const uint64_t begin = first + i * kGroupSize;
    const uint32_t size = static_cast<uint32_t>(min(uint64_t{kGroupSize}, first + count - begin));
    for (uint32_t k = group.rank; k < size; k += group.size) {
      const Triangle t = triangles[begin + k];
      const Real inflation = widened(halves.inflation(deviations.inflation(motion.inflation, t.x), t.x), margin);
      const TriangleRecord<Real> made = shared.record[k] = record(t, begin + k, inflation);
      const Box<float> box = join(made.edge[0].box(), made.edge[1].box());
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
    const CornerRecord<Real> a = corner(t.x, e.x, own, inflation), b = corner(t.y, e.y, own >> 1, inflation),
                             c = corner(t.z, e.z, own >> 2, inflation);
    return {{a, b, c}, {edge(a, b, inflation), edge(b, c, inflation), edge(c, a, inflation)}};
  }
  /// Bit 0 of `own`: owns the vertex.
  COLLIDED_HD CornerRecord<Real> corner(uint32_t v, uint32_t e, uint32_t own, Real inflation) const {
    const Path<Real> path{motion.start[v], motion.end[v]};
    if constexpr (kRoundsBoxes<Real>) {
      if ((own & 1u) != 0) paths[v] = path;
    }
    return CornerRecord<Real>::of(path, inflation, v, e);
  }
  COLLIDED_HD static EdgeRecord edge(const CornerRecord<Real>& from, const CornerRecord<Real>& to, Real inflation) {
    const Box<float> box = from.box_to(to, inflation);
    return {box.lo, from.vertex, box.hi, to.vertex};
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
