#pragma once
// The triangles that are nearest to vertices in solids.

#include <limits>

#include "gpu/base/keys.hpp"
#include "gpu/contacts/columns.hpp"
#include "gpu/solids/distance.hpp"
#include "gpu/solids/inside.hpp"

namespace collided {

/// Triangles that the threads of a group, which is one thread or a warp, share out among themselves.
class LeavesOfGroup {
 public:
  COLLIDED_HD explicit LeavesOfGroup(const Group& group) : group_(group) {}

  /// All threads give the same ones.
  COLLIDED_HD void give(uint32_t place) {
    if (count_ == group_.rank) own_ = place;
    ++count_;
  }
  COLLIDED_HD bool has() const { return group_.rank < count_; }
  COLLIDED_HD uint32_t own() const { return own_; }
  COLLIDED_HD bool is_full() const { return count_ == group_.size; }
  /// Whether it is time to look at them, since that saves looking at others.
  COLLIDED_HD bool are_many() const { return count_ >= kMany; }
  COLLIDED_HD void take() { count_ = 0; }

 private:
  static constexpr uint32_t kMany = 4;

  const Group& group_;
  uint32_t count_ = 0, own_ = 0;
};

/// What the threads of a group have measured.
struct MeasuredByGroup {
  static constexpr uint32_t kMost = 32;

  PreciseDistance found[kMost];
  uint32_t place[kMost];
  bool is_near[kMost];
};

/// A vertex in a solid, and the solid's triangles by their distances from it.
template <class Real>
class SolidFromVertex {
 public:
  COLLIDED_HD SolidFromVertex(const SolidTree<Real>& tree, const Box<Real>& bounds, uint64_t key)
      : tree_(tree), from_(tree.point(first_id(key))), solid_(second_id(key)) {
    const Vec3<double> half = 0.5 * convert<double>(bounds.hi) - 0.5 * convert<double>(bounds.lo);
    scale_ = unit_scale(max(half.x, max(half.y, half.z)));
  }

  COLLIDED_HD double unscaled(double length) const { return length / scale_; }

  /// Returns a squared distance that the nearest triangle is certain to have or be below. Goes down to what is nearer
  /// first; the threads of a group go together, and look at a triangle each.
  COLLIDED_HD double reach(const Group& group) const {
    constexpr int kDeepest = 96;  // the bits of a leaf's key and of its place
    uint32_t later[kDeepest];
    int count = 0;
    double reach = std::numeric_limits<double>::infinity();
    LeavesOfGroup leaves(group);
    const auto look = [&] {
      reach = min(reach, -group.most(leaves.has() ? -reach_of(leaves.own()) : -reach));
      leaves.take();
    };
    const auto give = [&](uint32_t place) {
      leaves.give(place);
      if (leaves.is_full()) look();
    };
    for (uint32_t left = tree_.parts[solid_].left; left != kNoNode;) {
      const BvhNode nodes[2] = {tree_.nodes[left], tree_.nodes[left | 1u]};
      const double squared[2] = {from_box(nodes[0].box()), from_box(nodes[1].box())};
      const int nearer = squared[1] < squared[0] ? 1 : 0;
      left = kNoNode;
      for (int k = 0; k < 2; ++k) {
        const int side = k == 0 ? nearer : 1 - nearer;
        const BvhNode& node = nodes[side];
        if (!(squared[side] <= reach)) continue;
        if (node.is_leaf())
          give(node.triangle());
        else if (left == kNoNode)
          left = node.child;
        else
          later[count++] = node.child;
      }
      if (leaves.are_many()) look();
      if (left == kNoNode && count > 0) left = later[--count];
    }
    look();
    return reach;
  }
  /// use(place, distance), by all threads of a group, for each triangle that may be within a squared distance. They
  /// measure a triangle each; `shared`: the group's.
  template <class Use>
  COLLIDED_HD void for_each_within(double reach, const Group& group, MeasuredByGroup& shared, const Use& use) const {
    LeavesOfGroup leaves(group);
    const auto measure = [&] {
      shared.is_near[group.rank] = false;
      if (leaves.has()) {
        const RoughDistance rough = rough_distance(leaves.own());
        shared.is_near[group.rank] = rough.squared - rough.error <= reach;
        if (shared.is_near[group.rank]) shared.found[group.rank] = precise(leaves.own());
        shared.place[group.rank] = leaves.own();
      }
      group.sync();
      for (uint32_t k = 0; k < group.size; ++k)
        if (shared.is_near[k]) use(shared.place[k], shared.found[k]);
      group.sync();
      leaves.take();
    };
    tree_.walk_one(
        solid_, [&](const Box<float>& box) { return from_box(box) <= reach; },
        [&](uint32_t place) {
          leaves.give(place);
          if (leaves.is_full()) measure();
        });
    measure();
  }
  COLLIDED_HD PreciseDistance precise(uint32_t place) const {
    Vec3<double> corners[3];
    tree_.corners_of(place, corners);
    return precise_distance(SeenTriangle(from_, corners, scale_));
  }
  /// Whether the closest points of two triangles are one point of a feature that they share.
  COLLIDED_HD bool share_point(uint32_t p, const PreciseDistance& of_p, uint32_t q, const PreciseDistance& of_q) const {
    if (of_p.corners == 0 || of_q.corners == 0) return false;
    const NamedFeature a = feature_of(p, of_p.corners), b = feature_of(q, of_q.corners);
    return !a.is_before(b) && !b.is_before(a);
  }

 private:
  COLLIDED_HD double from_box(const Box<float>& box) const {
    const auto outside = [&](float lo, float hi, double x) {
      return scale_ * max(max(double{lo} - x, x - double{hi}), 0.0);
    };
    const double x = outside(box.lo.x, box.hi.x, from_.x), y = outside(box.lo.y, box.hi.y, from_.y),
                 z = outside(box.lo.z, box.hi.z, from_.z);
    return (1 - 0x1p-48) * (x * x + y * y + z * z);
  }
  COLLIDED_HD RoughDistance rough_distance(uint32_t place) const {
    Vec3<double> corners[3];
    tree_.corners_of(place, corners);
    for (Vec3<double>& corner : corners) corner = scale_ * (corner - from_);
    return collided::rough_distance(corners);
  }
  COLLIDED_HD double reach_of(uint32_t place) const {
    const RoughDistance rough = rough_distance(place);
    return rough.squared + rough.error;
  }
  COLLIDED_HD NamedFeature feature_of(uint32_t place, int corners) const {
    const Vec3<uint32_t> t = tree_.triangles[place].corners;
    if (corners == 7) return NamedFeature::face(t.x, t.y, t.z);
    if (corners == 3) return NamedFeature::side(t.x, t.y);
    if (corners == 6) return NamedFeature::side(t.y, t.z);
    if (corners == 5) return NamedFeature::side(t.z, t.x);
    return NamedFeature::corner(corners == 1 ? t.x : corners == 2 ? t.y : t.z);
  }

  const SolidTree<Real>& tree_;
  Vec3<double> from_;
  uint32_t solid_;
  double scale_;
};

/// A triangle of the table that may be as near to a vertex in a solid as the nearest one.
struct Rival {
  uint32_t pair, place;
};

/// Writes a contact for each vertex in a solid: with the nearest triangle, of those that cannot be told apart the one
/// that seems nearer, and of those that share the closest point the one with the lowest id.
template <class Real>
struct FindNearest {
  SolidTree<Real> tree;
  const Box<Real>* bounds;
  Span<const uint64_t> inside;
  ContactColumns columns;
  bool is_exact;
  AppendList<Rival> rivals;  ///< at kExact: those that only the host can tell apart from the nearest

  using Shared = MeasuredByGroup;
  static constexpr uint32_t kGroupSize = MeasuredByGroup::kMost;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    const SolidFromVertex<Real> seen(tree, *bounds, inside[i]);
    const double reach = seen.reach(group);
    uint32_t nearest = kNoNode;
    PreciseDistance best;
    seen.for_each_within(reach, group, shared, [&](uint32_t place, const PreciseDistance& found) {
      if (nearest == kNoNode || is_before(seen, place, found, nearest, best)) nearest = place, best = found;
    });
    if (group.rank == 0) put(i, seen, nearest, best);
    if (!is_exact) return;
    bool has_rivals = false;
    const auto list = [&](uint32_t place) {
      if (group.rank == 0) rivals.push({static_cast<uint32_t>(i), place});
    };
    seen.for_each_within(reach, group, shared, [&](uint32_t place, const PreciseDistance& found) {
      if (place == nearest || found.compare(best) != 0) return;
      if (place > nearest && seen.share_point(place, found, nearest, best)) return;
      list(place);
      has_rivals = true;
    });
    if (has_rivals) list(nearest);
  }
  /// Writes contact i with this triangle.
  COLLIDED_HD void put_at(uint64_t i, uint32_t place) const {
    const SolidFromVertex<Real> seen(tree, *bounds, inside[i]);
    put(i, seen, place, seen.precise(place));
  }

 private:
  COLLIDED_HD static bool is_before(const SolidFromVertex<Real>& seen, uint32_t place, const PreciseDistance& found,
                                    uint32_t nearest, const PreciseDistance& best) {
    const int order = found.compare(best);
    if (order != 0) return order < 0;
    if (seen.share_point(place, found, nearest, best)) return place < nearest;
    const double difference = (found.squared - best.squared) + (found.low - best.low);
    return difference != 0 ? difference < 0 : place < nearest;
  }
  COLLIDED_HD void put(uint64_t i, const SolidFromVertex<Real>& seen, uint32_t place,
                       const PreciseDistance& found) const {
    const double depth = seen.unscaled(square_root(max(found.squared + found.low, 0.0)));
    columns.elements[i] = {first_id(inside[i]), tree.triangles[place].id};
    columns.flags[i] = kFlagCertified;
    columns.distance[i] = -max(depth, std::numeric_limits<double>::denorm_min());
    if (!columns.weights.empty()) columns.weights[i] = {found.w0, found.w1};
    if (!columns.normals.empty()) columns.normals[i] = normal(found.toward);
  }
  /// Of a direction of any length but 0.
  COLLIDED_HD static Normal normal(const Vec3<double>& toward) {
    const Vec3<double> near_1 = brought_near_1(toward);
    const double length = square_root(dot(near_1, near_1));
    const Vec3<float> n = convert<float>((1 / length) * near_1);
    return {n.x, n.y, n.z};
  }
};

/// Writes the contacts of vertices whose nearest triangle the host has found.
template <class Real>
struct PutNearest {
  FindNearest<Real> find;
  Span<const Rival> found;

  COLLIDED_HD void operator()(uint64_t k) const { find.put_at(found[k].pair, found[k].place); }
};

}  // namespace collided
