#pragma once
// A hierarchy over the triangles of all solids (engines/lbvh/lbvh.hpp), in which leaves are places in the table of
// these triangles.

#include "gpu/boxes/boxes.hpp"
#include "gpu/contacts/solid_meshes.hpp"
#include "gpu/engines/lbvh/lbvh.hpp"

namespace collided {

/// Where a triangle of a solid is.
template <class Real>
struct ExtentOfSolid {
  const Vec3<Real>* positions;
  Span<const SolidTriangle> triangles;

  COLLIDED_HD Box<Real> operator()(uint64_t i) const {
    const Vec3<uint32_t> corners = triangles[i].corners;
    const Vec3<Real> a = positions[corners.x], b = positions[corners.y], c = positions[corners.z];
    return join(join(Box<Real>{a, a}, Box<Real>{b, b}), Box<Real>{c, c});
  }
};

/// Boxes, and keys to sort them by.
template <class Real>
struct PlaceSolids {
  ExtentOfSolid<Real> extent;
  const Box<Real>* bounds;
  Span<Box<float>> boxes;
  Span<uint64_t> keys;
  Span<uint32_t> places, meeting;
  int axis_bits;

  COLLIDED_HD void operator()(uint64_t i) const {
    boxes[i] = outward_float(extent(i));
    keys[i] = MortonKeys::morton_of(boxes[i], outward_float(*bounds), axis_bits);
    places[i] = static_cast<uint32_t>(i);
    meeting[i] = kNoNode;
  }
};

/// The solids' triangles where they are, and the hierarchy over them.
template <class Real>
struct SolidTree {
  const Vec3<Real>* positions;
  Span<const SolidTriangle> triangles;
  Span<const BvhNode> nodes;
  const uint32_t* top;  ///< the root's left child

  COLLIDED_HD Vec3<double> point(uint32_t vertex) const { return convert<double>(positions[vertex]); }
  COLLIDED_HD void corners_of(uint32_t place, Vec3<double> (&corners)[3]) const {
    const Vec3<uint32_t> ids = triangles[place].corners;
    corners[0] = point(ids.x), corners[1] = point(ids.y), corners[2] = point(ids.z);
  }
  /// use(place) for each triangle whose box meets(box).
  template <class Meets, class Use>
  COLLIDED_HD void walk(const Meets& meets, const Use& use) const {
    uint32_t at = *top;
    while (at != kNoNode) {
      const BvhNode node = nodes[at];
      const bool goes_below = meets(node.box());
      if (goes_below && node.is_leaf()) use(node.triangle());
      at = goes_below && !node.is_leaf() ? node.child : node.rope;
    }
  }
};

}  // namespace collided
