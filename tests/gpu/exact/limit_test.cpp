// Limits that are sums of three doubles, against rational arithmetic: at the limit and a hair to either side of it,
// with exponents close together and far apart.

#include <gmpxx.h>

#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

mpq_class sum_of(const ContactDistance& limit) {
  return mpq_class(limit.thickness) + mpq_class(limit.first) + mpq_class(limit.second);
}

/// Random parts of any sizes, often 0, alike, or far apart.
class Limits {
 public:
  explicit Limits(uint32_t seed) : random_(seed) {}
  ContactDistance next(int exponents) {
    const int about = any(exponents);
    return {part(about, exponents), part(about, exponents), part(about, exponents)};
  }
  uint32_t any_of(uint32_t count) { return static_cast<uint32_t>(random_() % count); }

 private:
  int any(int exponents) { return std::uniform_int_distribution<int>(-exponents, exponents)(random_); }
  double part(int about, int exponents) {
    if (any_of(5) == 0) return 0;
    const int exponent = any_of(2) == 0 ? about - static_cast<int>(any_of(56)) : any(exponents);
    const double digits = any_of(2) == 0 ? 1 : std::uniform_real_distribution<double>(1, 2)(random_);
    return std::ldexp(digits, std::max(exponent, -1074));
  }

  std::mt19937_64 random_;
};

// above() and below() are doubles beside the sum, and the sum itself if it has one part.
TEST(ExactLimit, BoundsAreTight) {
  Limits limits(1);
  for (int i = 0; i < 200000; ++i) {
    const ContactDistance limit = limits.next(i % 2 == 0 ? 40 : 1000);
    const mpq_class sum = sum_of(limit);
    const double above = limit.above(), below = limit.below();
    ASSERT_TRUE(mpq_class(below) <= sum && sum <= mpq_class(above)) << i;
    const int parts = (limit.thickness != 0) + (limit.first != 0) + (limit.second != 0);
    if (parts < 2) {
      ASSERT_EQ(below, above) << i;
    }
    ASSERT_EQ(below == 0, sum == 0) << i;
    ASSERT_EQ(limit.is_zero(), sum == 0) << i;
    double up = limit.nearly();
    for (int k = 0; k < 4; ++k) up = std::nextafter(up, HUGE_VAL);
    ASSERT_LE(above, up) << i;
  }
}

/// Features whose closest points are inside both, `gap` apart, or come to be so at t = 1.
struct Features {
  ContactKind kind;
  Query query;
};
Features apart_by(double gap, bool is_vertex_triangle, double size) {
  const Point e{size, 0, 0}, f{0, size, 0}, up{0, 0, gap}, start{0, 0, 4 * gap};
  if (is_vertex_triangle) {
    const Point a{-size, -size, 0}, b{size + size, -size, 0}, c{-size, size + size, 0};
    return {ContactKind::kVertexTriangle, {{start, a, b, c}, {up, a, b, c}}};
  }
  return {ContactKind::kEdgeEdge, {{kOrigin - e, e, start - f, start + f}, {kOrigin - e, e, up - f, up + f}}};
}

TEST(ExactLimit, DecidesByTheRealSum) {
  Limits limits(2);
  size_t hits = 0, misses = 0;
  for (int i = 0; i < 3000; ++i) {
    const ContactDistance limit = limits.next(i % 3 == 0 ? 400 : 30);
    if (limit.is_zero()) continue;
    const mpq_class sum = sum_of(limit);
    double gap = limit.nearly();
    for (int k = 0; k < 2; ++k) gap = std::nextafter(gap, 0);
    for (int k = 0; k < 5; ++k, gap = std::nextafter(gap, HUGE_VAL)) {
      const bool is_vertex_triangle = limits.any_of(2) == 0;
      const double size = std::ldexp(1, static_cast<int>(limits.any_of(3)) * 20 - 20) * limit.nearly();
      const auto [kind, q] = apart_by(gap, is_vertex_triangle, size);
      const bool expected = mpq_class(gap) <= sum;
      ASSERT_EQ(exact_proximity(kind, q.end, limit), expected) << i << " " << k;
      const ExactImpact impact = exact_ccd(kind, q.start, q.end, limit);
      ASSERT_EQ(impact.hit, expected) << i << " " << k;
      ASSERT_FALSE(impact.initial) << i;
      ASSERT_TRUE(exact_ccd(kind, q.end, q.start, limit).initial == expected) << i;
      ++(expected ? hits : misses);
    }
  }
  EXPECT_GT(hits, 3000u);
  EXPECT_GT(misses, 3000u);
}

}  // namespace
}  // namespace collided::test
