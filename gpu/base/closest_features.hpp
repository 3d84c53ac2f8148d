#pragma once
// Decides on which features the closest points of a vertex and a triangle, or of two edges, are. The rules are written
// once for all numbers: in double precision (narrow/closest_features.hpp) and in integers (exact/closest_features.cpp).
//
// The squared distance is convex, so each rule is what makes a point a minimum (Karush, Kuhn and Tucker): no direction
// in which the features go on from there leads nearer. That is a sign of a polynomial of at most degree 4 in the
// differences of the points. Features without length or area need no rules of their own:
// - A corner, or an end of each edge: neither direction from there leads nearer.
// - The inside of a side or an edge, at the foot of a point: the foot is strictly inside, and the direction into the
//   triangle, or along the edge that the point ends, does not lead nearer. A side with another corner at the foot is
//   not the answer, because that corner is.
// - The triangle's face, or the insides of both edges: what is left.
// Rules of features with the same points may hold together. Then the lowest dimension counts, and of equal dimension
// the least ids of the vertices that the features have; of equal ids, the first in the order of the stencil.

#include "gpu/base/host_device.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// The features, in the bits that FeatureBits (contact_set.hpp) has for them.
struct FoundFeatures {
  uint8_t features;
  bool is_certain;  ///< real arithmetic gives the same
};

/// Says if a condition holds. If that is not certain, it counts as a tie, in which it does.
struct Judged {
  bool holds, is_certain;
};
COLLIDED_HD inline Judged operator!(const Judged& a) { return {!a.holds, a.is_certain}; }
COLLIDED_HD inline Judged operator&(const Judged& a, const Judged& b) {
  const bool fails = (a.is_certain && !a.holds) || (b.is_certain && !b.holds);
  return {a.holds && b.holds, fails || (a.is_certain && b.is_certain)};
}

/// Sixteen judged conditions by number.
class JudgedSet {
 public:
  COLLIDED_HD Judged operator[](int k) const { return {(holds_ >> k & 1u) != 0, (certain_ >> k & 1u) != 0}; }
  COLLIDED_HD void set(int k, const Judged& judged) {
    holds_ |= (judged.holds ? 1u : 0u) << k;
    certain_ |= (judged.is_certain ? 1u : 0u) << k;
  }

 private:
  uint32_t holds_ = 0, certain_ = 0;
};

/// Vertices that features of equal dimension have, in the order in which ties prefer them.
COLLIDED_HD inline uint64_t tie_order(uint32_t a, uint32_t b) { return uint64_t{min(a, b)} << 32 | max(a, b); }

/// The first, in the order of ties, of the features of one dimension whose conditions hold.
class FeatureChoice {
 public:
  COLLIDED_HD void take(const Judged& condition, uint64_t order, int features) {
    all_are_certain_ = all_are_certain_ && condition.is_certain;
    if (!condition.holds || (is_found_ && order_ <= order)) return;
    is_found_ = true;
    order_ = order;
    features_ = static_cast<uint8_t>(features);
  }
  COLLIDED_HD bool is_found() const { return is_found_; }
  COLLIDED_HD bool is_certain() const { return all_are_certain_; }
  COLLIDED_HD uint8_t features() const { return features_; }

 private:
  uint64_t order_ = 0;
  uint8_t features_ = 0;
  bool is_found_ = false, all_are_certain_ = true;
};

/// The rules, for four points and their vertices' ids. Numbers has
/// - d(i, j): the vector from point i to point j;
/// - dot(a, b): of two of these vectors, a number x such that x * x - x * x is one, too;
/// - not_positive(x): Judged, if such a number is <= 0.
template <class Numbers>
class ClosestFeatureRules {
 public:
  COLLIDED_HD ClosestFeatureRules(const Numbers& numbers, const uint32_t (&ids)[4]) : numbers_(numbers), ids_(ids) {}

  /// Points v a b c.
  COLLIDED_HD FoundFeatures vertex_triangle() const {
    JudgedSet before;  // 4 x + y
    for_each_corner([&](int x, int y, int z) {
      before.set(4 * x + y, is_before(0, x, y));
      before.set(4 * x + z, is_before(0, x, z));
    });
    FeatureChoice corner;
    for_each_corner([&](int x, int y, int z) { corner.take(before[4 * x + y] & before[4 * x + z], ids_[x], 3 + x); });
    if (corner.is_found()) return {corner.features(), corner.is_certain()};
    FeatureChoice side;
    for_each_corner([&](int z, int x, int y) {
      // Any point of the side would do to see the third corner from. In a loose edge the third corner is one of its
      // ends, and the direction from this end is 0 in all numbers.
      const auto inward = ids_[z] == ids_[y] ? numbers_.d(y, z) : numbers_.d(x, z);
      side.take(!before[4 * x + y] & !before[4 * y + x] & leads_away(0, x, y, inward), tie_order(ids_[x], ids_[y]), z);
    });
    return {side.features(), corner.is_certain() && side.is_certain()};
  }

  /// Points a0 a1 b0 b1.
  COLLIDED_HD FoundFeatures edge_edge() const {
    JudgedSet before;  // 4 x + p
    for_each_end_of_both([&](int i, int j) {
      before.set(4 * i + j, is_before(j, i, 1 - i));
      before.set(4 * j + i, is_before(i, j, 5 - j));
    });
    FeatureChoice ends;
    for_each_end_of_both([&](int i, int j) {
      ends.take(before[4 * i + j] & before[4 * j + i], tie_order(ids_[i], ids_[j]), on_first(i) | on_second(j));
    });
    if (ends.is_found()) return {ends.features(), ends.is_certain()};
    FeatureChoice end;
    const auto take_end = [&](int p, int other, int x, int y, int features) {
      end.take(!before[4 * x + p] & !before[4 * y + p] & leads_away(p, x, y, numbers_.d(other, p)), ids_[p], features);
    };
    take_end(0, 1, 2, 3, on_first(0)), take_end(1, 0, 2, 3, on_first(1));
    take_end(2, 3, 0, 1, on_second(2)), take_end(3, 2, 0, 1, on_second(3));
    return {end.features(), ends.is_certain() && end.is_certain()};
  }

 private:
  COLLIDED_HD static int on_first(int i) { return i + 1; }
  COLLIDED_HD static int on_second(int j) { return (j - 1) << 2; }

  // Written out, so that a GPU holds what is numbered in registers.

  /// use(corner, next, next but one).
  template <class Use>
  COLLIDED_HD static void for_each_corner(const Use& use) {
    use(1, 2, 3), use(2, 3, 1), use(3, 1, 2);
  }
  template <class Use>
  COLLIDED_HD static void for_each_end_of_both(const Use& use) {
    use(0, 2), use(1, 2), use(0, 3), use(1, 3);
  }

  /// (p - x) (y - x) <= 0: the way from x to y does not lead nearer to p.
  COLLIDED_HD Judged is_before(int p, int x, int y) const {
    return numbers_.not_positive(numbers_.dot(numbers_.d(x, p), numbers_.d(x, y)));
  }
  /// (p - f) w <= 0 for the foot f of p on the line x y, times (y - x)^2.
  template <class Vector>
  COLLIDED_HD Judged leads_away(int p, int x, int y, const Vector& w) const {
    const Vector xp = numbers_.d(x, p), xy = numbers_.d(x, y);
    return numbers_.not_positive(numbers_.dot(w, xp) * numbers_.dot(xy, xy) -
                                 numbers_.dot(xy, xp) * numbers_.dot(w, xy));
  }

  const Numbers& numbers_;
  const uint32_t (&ids_)[4];
};

}  // namespace collided
