// What the boxes in the records of triangles decide in double, against the boxes that make candidates.

#include "gpu/boxes/records.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "gpu/search/elementary.hpp"

namespace collided::test {
namespace {

/// Where float is coarse: coordinates are some steps from a corner.
struct Place {
  const char* name;
  double corner, step;
};

constexpr double kLimit = std::numeric_limits<double>::max() / 8;
constexpr Place kPlaces[] = {{"Near", 1, 0x1p-26},
                             {"Far", 1e8, 0.5},
                             {"FarBelowZero", -1e8, 0.5},
                             {"SubnormalInFloat", -0x1p-147, 0x1p-151},
                             {"Subnormal", -0x1p-1070, 0x1p-1074},
                             {"AtTheLargestFloat", 0x1.fffffcp127, 0x1p102},
                             {"PastTheLargestFloat", 1e60, 1e45},
                             {"AtTheLimit", kLimit, -0x1p970}};

/// Triangles that share no vertex.
class Records : public testing::TestWithParam<Place> {
 protected:
  static constexpr uint32_t kTriangles = 48;

  /// Every other triangle stands still.
  void SetUp() override {
    for (uint32_t v = 0; v < 3 * kTriangles; ++v) {
      start_.push_back(point());
      end_.push_back(v / 3 % 2 == 0 ? point() : start_.back());
      if (v % 3 == 0) triangles_.push_back({v, v + 1, v + 2});
    }
  }
  void box_triangles(double inflation) {
    inflation_ = inflation;
    const auto shared = std::make_unique<BoxTriangles<double>::Shared>();
    const Span<Triangle> triangles{triangles_.data(), kTriangles};
    BoxTriangles<double>{{start_.data(), end_.data(), inflation},
                         {},
                         triangles,
                         triangles,
                         owned(),
                         0,
                         kTriangles,
                         {boxes_, kTriangles},
                         {records_, kTriangles},
                         {paths_, 3 * kTriangles},
                         {}}(0, Group{0, 1}, *shared);
  }
  ElementaryTests<double> tests() const {
    return {{{records_, kTriangles}, {paths_, 3 * kTriangles}}, owned(), {inflation_}, true, true};
  }

  /// Of vertices of a triangle, counted round.
  Box<double> box(uint32_t triangle, int first, int count) const {
    Box<double> all = empty_box<double>();
    for (int k = first; k < first + count; ++k) {
      const uint32_t v = 3 * triangle + static_cast<uint32_t>(k % 3);
      all = join(all, join(Box<double>{start_[v], start_[v]}, Box<double>{end_[v], end_[v]}));
    }
    return inflate(all, inflation_);
  }

  /// Whether a test's boxes overlap in double; `told`: what the records say.
  void expect(const Box<double>& a, const Box<double>& b, bool told) {
    const Box<float> p = outward_float(a), q = outward_float(b);
    ASSERT_EQ(told, overlap(a, b));
    ASSERT_TRUE(overlap(p, q) || !told) << "boxes that are rounded outward lose nothing";
    ASSERT_TRUE(!surely_overlap(p, q) || told);
    if (overlap(p, q) && !surely_overlap(p, q)) ++doubts_[told ? 1 : 0];
  }

  uint64_t doubts_[2] = {0, 0};  ///< boxes that are apart, and those that overlap

 private:
  Vec3<double> point() { return {coordinate(), coordinate(), coordinate()}; }
  double coordinate() { return GetParam().corner + static_cast<double>(random_() % 64) * GetParam().step; }
  static Span<const uint8_t> owned() {
    static const std::vector<uint8_t> all(kTriangles, 63);
    return {all.data(), all.size()};
  }

  std::mt19937 random_{7};
  std::vector<Vec3<double>> start_, end_;
  std::vector<Triangle> triangles_;
  double inflation_ = 0;
  Box<float> boxes_[kTriangles];
  TriangleRecord<double> records_[kTriangles];
  Path<double> paths_[3 * kTriangles];
};

TEST_P(Records, DecideAsBoxesInDoubleDo) {
  for (const double steps : {0.0, 2.0}) {
    box_triangles(steps * std::abs(GetParam().step));
    for (uint32_t b = 0; b < kTriangles; ++b)
      for (uint32_t a = 0; a < b; ++a)
        for (int k = 0; k < 3; ++k) {
          expect(box(a, k, 1), box(b, 0, 3), tests().vertex_triangle_overlap(a, b, k));
          expect(box(b, k, 1), box(a, 0, 3), tests().vertex_triangle_overlap(a, b, 3 + k));
          for (int m = 0; m < 3; ++m)
            expect(box(a, k, 2), box(b, m, 2), tests().edge_edge_overlap(a, b, edge_edge_test(k, m)));
        }
  }
  EXPECT_GT(doubts_[0], 0u);
  EXPECT_GT(doubts_[1], 0u);
}

INSTANTIATE_TEST_SUITE_P(Places, Records, testing::ValuesIn(kPlaces), [](const auto& info) { return info.param.name; });

TEST(SurelyOverlap, NeedsAFloatBetween) {
  const auto boxes_meet = [](float lo, float hi) {
    const Box<float> wide{{-8, -8, -8}, {8, 8, 8}};
    Box<float> low = wide, high = wide;
    low.hi.x = hi, high.lo.x = lo;
    return surely_overlap(low, high);
  };
  for (const float x : {-3.0f, -0x1p-149f, 0.0f, 0x1p-130f, 1.0f, 5.0f}) {
    EXPECT_FALSE(boxes_meet(x, x)) << x;
    EXPECT_FALSE(boxes_meet(x, next_up(x))) << x;
    EXPECT_FALSE(boxes_meet(next_up(x), x)) << x;
    EXPECT_TRUE(boxes_meet(x, x + 0x1p-19f)) << x;
  }
}

}  // namespace
}  // namespace collided::test
