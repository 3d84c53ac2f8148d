#pragma once
// A query's coordinates as multiples of one power of two, and the differences that the decisions are made of.
//
// With W limbs a coordinate is below 2^(64 W - 4). That leaves room for all sums, w = 64 W:
//   differences                          below 2^(w - 3)
//   a contact distance D, the sum of three numbers: below 3 * 2^(w - 4)
//   their cross products, at any power of t, and sums of three:        below 2^(2 w - 2)
//   the volume, at any power of t        below 2^(3 w - 3)
//   (D |n|)^2 with the features' normal n, at any power of t: below 20 * 9 * 9 * 2^(6 w - 20)
//   the volume at a time k / 2^60, times 2^180: below 2^(3 w + 180)

#include <climits>

#include "gpu/base/contact_distance.hpp"
#include "gpu/contact_set.hpp"
#include "gpu/exact/fixed/motion.hpp"

namespace collided::exact::fixed {

/// The largest power of two that divides all numbers seen, and the bits that they have above it.
class Unit {
 public:
  COLLIDED_HD void see(double x) {
    const Binary b(x);
    if (b.mantissa == 0) return;
    lowest_ = min(lowest_, b.exponent + trailing_zeros(b.mantissa));
    highest_ = max(highest_, b.exponent + 64 - leading_zeros(b.mantissa));
  }
  template <int n>
  COLLIDED_HD void see(const Vec3<double> (&points)[n]) {
    for (const Vec3<double>& p : points) see(p.x), see(p.y), see(p.z);
  }
  COLLIDED_HD void see(const ContactDistance& x) { see(x.thickness), see(x.first), see(x.second); }
  /// Whether W limbs will do for the numbers seen.
  template <int W>
  COLLIDED_HD bool fits() const {
    return lowest_ > highest_ || highest_ - lowest_ <= 64 * W - 4;
  }
  /// Of a number seen.
  template <int W>
  COLLIDED_HD Integer<W> count(double x) const {
    static_assert(W <= 2);
    const Binary b(x);
    if (b.mantissa == 0) return Integer<W>::of(0);  // where all are 0, there is no lowest
    const int shift = b.exponent - lowest_;
    const Double mantissa = b.mantissa, n = shift < 0 ? mantissa >> -shift : mantissa << shift;
    Integer<W> r;
    for (int i = 0; i < W; ++i) r.limb[i] = static_cast<uint64_t>(n >> (64 * i));
    return b.is_negative ? Integer<W>::of(0) - r : r;
  }
  template <int W>
  COLLIDED_HD Vec3<Integer<W>> count(const Vec3<double>& p) const {
    return {count<W>(p.x), count<W>(p.y), count<W>(p.z)};
  }

  template <int W>
  COLLIDED_HD Integer<W> count(const ContactDistance& x) const {
    return count<W>(x.thickness) + count<W>(x.first) + count<W>(x.second);
  }

 private:
  /// x = mantissa * 2^exponent, but for the sign.
  struct Binary {
    uint64_t mantissa;
    int exponent;
    bool is_negative;

    COLLIDED_HD explicit Binary(double x) {
      const uint64_t bits = detail::bit_copy<uint64_t>(x);
      const int field = static_cast<int>(bits >> 52 & 2047);
      mantissa = (bits & ((uint64_t{1} << 52) - 1)) | (field != 0 ? uint64_t{1} << 52 : 0);
      exponent = max(field, 1) - 1075;
      is_negative = (bits >> 63) != 0;
    }
  };
  int lowest_ = INT_MAX, highest_ = INT_MIN;
};

/// A = v - a, B = v - b, C = v - c; or A = a0 - b0, B = a0 - b1, C = a1 - b0, D = a1 - b1, as in exact/features.cpp.
template <ContactKind kind, int W>
struct Differences {
  static constexpr int kCount = kind == ContactKind::kVertexTriangle ? 3 : 4;
  Moving<W> d[kCount];

  Differences() = default;
  COLLIDED_HD Differences(const Unit& unit, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4]) {
    set(unit, start, 0);
    set(unit, end, 1);
  }

 private:
  COLLIDED_HD void set(const Unit& unit, const Vec3<double> (&points)[4], int at) {
    Vec3<Integer<W>> p[4];
    for (int i = 0; i < 4; ++i) p[i] = unit.count<W>(points[i]);
    for (int i = 0; i < kCount; ++i) d[i].p[at] = kCount == 3 ? p[0] - p[i + 1] : p[i / 2] - p[2 + i % 2];
  }
};

/// The differences whose cross product P x Q tells on which side of one side of the features their common point is.
struct Side {
  int p, q;
};
template <ContactKind kind>
struct Sides;
template <>
struct Sides<ContactKind::kVertexTriangle> {
  static constexpr int kCount = 3;
  COLLIDED_HD static Side at(int i) { return {(i + 1) % 3, (i + 2) % 3}; }  // B C, C A, A B
};
template <>
struct Sides<ContactKind::kEdgeEdge> {
  static constexpr int kCount = 4;
  COLLIDED_HD static Side at(int i) {  // A B, D C, C A, B D
    return i == 0 ? Side{0, 1} : i == 1 ? Side{3, 2} : i == 2 ? Side{2, 0} : Side{1, 3};
  }
};

/// The features' common normal, of the cross products of all sides.
template <ContactKind kind, class Vector>
COLLIDED_HD Vector normal_of(const Vector* sides) {
  const Vector both = sides[0] + sides[1];
  if constexpr (kind == ContactKind::kEdgeEdge) return both;
  return both + sides[2];
}

}  // namespace collided::exact::fixed
