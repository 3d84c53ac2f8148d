#pragma once
// On which features the closest points of a contact are, in double precision: the rules of base/closest_features.hpp
// with bounds that say where real arithmetic agrees. The same bits on every backend.
//
// With u = 2^-53, a polynomial of degree 4 is a sum of products of four differences. Each product takes 4 roundings for
// its differences, 2 and 4 for products and sums of the two dot products, one for their product and one for the last
// difference. So the value is within (1 + u)^12 - 1 of the sum of the products' magnitudes, and that sum is computed
// within as much. 16 u covers both. Differences are scaled by a power of two, so that the largest is in [1, 2). Where
// all others are at least 2^-250, or 0, no product underflows, and a sum of magnitudes that is 0 has no term other than
// 0. If the differences are multiples of 2^-11, dot products have at most 26 bits and values at most 53: all of them
// are exact, and so is a 0.

#include "gpu/base/closest_features.hpp"
#include "gpu/base/precision.hpp"
#include "gpu/base/twofold.hpp"
#include "gpu/contacts/kinds.hpp"

namespace collided {

/// A sum, and the sum of its terms' magnitudes.
struct SizedSum {
  double value, size;
};
COLLIDED_HD inline SizedSum operator-(const SizedSum& a, const SizedSum& b) {
  return {a.value - b.value, a.size + b.size};
}
COLLIDED_HD inline SizedSum operator*(const SizedSum& a, const SizedSum& b) {
  return {a.value * b.value, a.size * b.size};
}

/// Four points' differences.
class SizedNumbers {
 public:
  COLLIDED_HD explicit SizedNumbers(const Vec3<double> (&points)[4]) : p_(points) {
    const double extent =
        max(extent_of(&Vec3<double>::x), max(extent_of(&Vec3<double>::y), extent_of(&Vec3<double>::z)));
    if (extent > 0 && extent <= kMaxExtent) scale_ = unit_scale(extent);
    is_in_range_ = extent <= kMaxExtent && (has_range(0, 1) && has_range(0, 2) && has_range(0, 3) && has_range(1, 2) &&
                                            has_range(1, 3) && has_range(2, 3));
    is_on_lattice_ = is_in_range_ && is_on_lattice(1) && is_on_lattice(2) && is_on_lattice(3);
  }

  COLLIDED_HD Vec3<double> d(int i, int j) const { return scale_ * (p_[j] - p_[i]); }
  COLLIDED_HD SizedSum dot(const Vec3<double>& a, const Vec3<double>& b) const {
    const double x = a.x * b.x, y = a.y * b.y, z = a.z * b.z;
    return {x + y + z, magnitude(x) + magnitude(y) + magnitude(z)};
  }
  COLLIDED_HD Judged not_positive(const SizedSum& a) const {
    const double bound = 0x1p-49 * a.size;
    const bool is_known = magnitude(a.value) > bound || a.size == 0 || (a.value == 0 && is_on_lattice_);
    return {a.value <= bound, is_in_range_ && is_known};
  }

 private:
  static constexpr double kMaxExtent = 0x1p1020, kMinComponent = 0x1p-250;

  COLLIDED_HD double extent_of(double Vec3<double>::*axis) const {
    const double a = p_[0].*axis, b = p_[1].*axis, c = p_[2].*axis, d = p_[3].*axis;
    return max(max(a, b), max(c, d)) - min(min(a, b), min(c, d));
  }
  COLLIDED_HD bool has_range(double difference) const {
    return difference == 0 || magnitude(scale_ * difference) >= kMinComponent;
  }
  COLLIDED_HD bool has_range(int i, int j) const {
    const Vec3<double> d = p_[j] - p_[i];
    return has_range(d.x) && has_range(d.y) && has_range(d.z);
  }
  /// Multiples of 2^-11 below 2 have exact differences: it is enough to look at those from one point.
  COLLIDED_HD bool is_on_lattice(int j) const {
    const Vec3<Twofold> d = exact_difference(p_[j], p_[0]);
    return is_on_lattice(d.x) && is_on_lattice(d.y) && is_on_lattice(d.z);
  }
  COLLIDED_HD bool is_on_lattice(const Twofold& difference) const {
    const double x = scale_ * difference.high;
    return difference.low == 0 && (x + 0x1.8p41) - 0x1.8p41 == x;
  }

  const Vec3<double> (&p_)[4];
  double scale_ = 1;
  bool is_in_range_ = false, is_on_lattice_ = false;
};

/// Returns on which features the closest points of two features are, as FeatureBits (contact_set.hpp) without its
/// upper bits. `points` are the stencil's, v a b c or a0 a1 b0 b1, with any finite coordinates; `ids` are its
/// vertices'. A polynomial whose sign is not certain counts as 0: edges that are parallel but for rounding have a
/// closest point at an end.
template <class Kind>
COLLIDED_HD FoundFeatures closest_features(const Vec3<double> (&points)[4], const uint32_t (&ids)[4]) {
  const SizedNumbers numbers(points);
  const ClosestFeatureRules rules(numbers, ids);
  if constexpr (std::is_same_v<Kind, VertexTriangle>)
    return rules.vertex_triangle();
  else
    return rules.edge_edge();
}

}  // namespace collided
