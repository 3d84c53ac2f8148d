#pragma once
// A hierarchy over the triangles of all solids (engines/lbvh/lbvh.hpp), in which leaves are places in the table of
// these triangles. Their keys tell first where the solid is, then which one it is, then where the triangle is. So each
// solid has a part of the hierarchy to itself, and solids that are near each other are near in it.

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

/// How the bits of a key are shared out.
struct SolidKeyBits {
  int place, solid, triangle;  ///< of a solid's place and a triangle's, along each axis

  explicit SolidKeyBits(uint64_t triangles, uint64_t solids)
      : place(solids > kFew ? 6 : 0), solid(std::bit_width(solids - 1)) {
    const int left = (64 - 3 * place - solid) / 3;
    triangle = left < MortonKeys::axis_bits_for(triangles) ? left : MortonKeys::axis_bits_for(triangles);
  }
  COLLIDED_HD int of_triangle() const { return 3 * triangle; }
  int all() const { return 3 * place + solid + 3 * triangle; }

 private:
  static constexpr uint64_t kFew = 16;  ///< so many are as well off in the order of their numbers
};

/// Boxes, and keys to sort them by.
template <class Real>
struct PlaceSolids {
  ExtentOfSolid<Real> extent;
  Span<const uint32_t> first_places;
  const Box<Real>* bounds;
  SolidKeyBits bits;
  Span<Box<float>> boxes;
  Span<uint64_t> keys;
  Span<uint32_t> places, meeting;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Box<float> all = outward_float(*bounds);
    boxes[i] = outward_float(extent(i));
    keys[i] = key_of(extent.triangles[i].solid, all) << bits.of_triangle() |
              MortonKeys::morton_of(boxes[i], all, bits.triangle);
    places[i] = static_cast<uint32_t>(i);
    meeting[i] = kNoNode;
  }
  /// Of a solid, which is where its first triangle is.
  COLLIDED_HD uint64_t key_of(uint32_t solid, const Box<float>& all) const {
    const Box<float> first = outward_float(extent(first_places[solid]));
    const uint64_t place = bits.place == 0 ? 0 : MortonKeys::morton_of(first, all, bits.place);
    return place << bits.solid | solid;
  }
};

/// The part of the hierarchy that a solid has to itself.
struct SolidPart {
  uint32_t node;  ///< that all its triangles are below; kNoNode: it is all
  uint32_t left;  ///< the left one of the two children
};

/// Finds the part of each solid. The leaves are in order.
template <class Real>
struct FindParts {
  PlaceSolids<Real> keys_of;
  BvhSplits splits;
  Span<const BvhNode> nodes;
  const uint32_t* top;  ///< the root's left child
  Span<SolidPart> parts;

  COLLIDED_HD void operator()(uint64_t solid) const {
    const uint64_t key = keys_of.key_of(static_cast<uint32_t>(solid), outward_float(*keys_of.bounds));
    const uint32_t first = first_from(key), last = first_from(key + 1) - 1;
    if (first == 0 && last + 1 == splits.leaves) {
      parts[solid] = {kNoNode, *top};
      return;
    }
    const uint32_t node = splits.is_left(first, last) ? 2 * last : 2 * first - 1;
    parts[solid] = {node, nodes[node].child};
  }

 private:
  /// Returns the first leaf whose solid has this key or a larger one.
  COLLIDED_HD uint32_t first_from(uint64_t key) const {
    uint32_t low = 0, high = splits.leaves;
    while (low < high) {
      const uint32_t middle = (low + high) / 2;
      if (splits.keys[middle] >> keys_of.bits.of_triangle() < key)
        low = middle + 1;
      else
        high = middle;
    }
    return low;
  }
};

/// The solids' triangles where they are, and the hierarchy over them.
template <class Real>
struct SolidTree {
  const Vec3<Real>* positions;
  Span<const SolidTriangle> triangles;
  Span<const BvhNode> nodes;
  Span<const SolidPart> parts;
  const uint32_t* top;  ///< the root's left child

  COLLIDED_HD Vec3<double> point(uint32_t vertex) const { return convert<double>(positions[vertex]); }
  COLLIDED_HD void corners_of(uint32_t place, Vec3<double> (&corners)[3]) const {
    const Vec3<uint32_t> ids = triangles[place].corners;
    corners[0] = point(ids.x), corners[1] = point(ids.y), corners[2] = point(ids.z);
  }
  /// use(place) for each triangle of all solids but one, or of all, whose box meets(box).
  template <class Meets, class Use>
  COLLIDED_HD void walk_others(uint32_t solid, const Meets& meets, const Use& use) const {
    const uint32_t left_out = solid == MeshVertex::kNoSolid ? kNoNode : parts[solid].node;
    walk(*top, kNoNode, left_out, meets, use);
  }
  /// The same for those of one solid.
  template <class Meets, class Use>
  COLLIDED_HD void walk_one(uint32_t solid, const Meets& meets, const Use& use) const {
    const SolidPart part = parts[solid];
    walk(part.left, part.node == kNoNode ? kNoNode : nodes[part.node].rope, kNoNode, meets, use);
  }

 private:
  template <class Meets, class Use>
  COLLIDED_HD void walk(uint32_t at, uint32_t end, uint32_t left_out, const Meets& meets, const Use& use) const {
    while (at != end) {
      const BvhNode node = nodes[at];
      const bool goes_below = at != left_out && meets(node.box());
      if (goes_below && node.is_leaf()) use(node.triangle());
      at = goes_below && !node.is_leaf() ? node.child : node.rope;
    }
  }
};

}  // namespace collided
