// The elementary tests of a pair, four boxes at a time, against one box after the other.

#include "gpu/search/cpu/feature_tests.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace collided::test {
namespace {

struct TestTriangle {
  Box<float> corner[3];
  Vec3<uint32_t> vertex, edge;
  uint32_t owned;

  FeatureBoxes features() const { return {corner, vertex, edge, owned}; }
  uint32_t id(int k) const { return k == 0 ? vertex.x : k == 1 ? vertex.y : vertex.z; }
  bool has(uint32_t v) const { return vertex.x == v || vertex.y == v || vertex.z == v; }
  Box<float> edge_box(int k) const { return join(corner[k], corner[(k + 1) % 3]); }
  Box<float> box() const { return join(corner[0], join(corner[1], corner[2])); }
};

uint32_t plain_tests(const TestTriangle& a, const TestTriangle& b) {
  uint32_t tests = 0;
  for (int k = 0; k < 3; ++k) {
    if ((a.owned >> k & 1) != 0 && !b.has(a.id(k)) && overlap(a.corner[k], b.box())) tests |= 1u << k;
    if ((b.owned >> k & 1) != 0 && !a.has(b.id(k)) && overlap(b.corner[k], a.box())) tests |= 1u << (3 + k);
    for (int m = 0; m < 3; ++m) {
      const uint32_t from = b.id(m), to = b.id((m + 1) % 3), v = a.id(k), w = a.id((k + 1) % 3);
      const bool within = v == from || v == to || w == from || w == to;
      const bool owned = (a.owned >> (3 + k) & b.owned >> (3 + m) & 1) != 0;
      if (owned && !within && overlap(a.edge_box(k), b.edge_box(m))) tests |= 1u << (6 + 4 * k + m);
    }
  }
  return tests;
}

class FeatureTests : public testing::Test {
 protected:
  /// Of few vertices, so that triangles share some; sides are whole numbers, so that boxes touch.
  TestTriangle triangle() {
    TestTriangle t;
    for (Box<float>& box : t.corner) {
      const Vec3<float> lo{number(6), number(6), number(6)};
      box = {lo, lo + Vec3<float>{number(3), number(3), number(3)}};
    }
    const uint32_t first = below(12);
    t.vertex = {first, (first + 1 + below(5)) % 12, (first + 6 + below(6)) % 12};
    t.edge = {t.vertex.x + 100, t.vertex.y + 100, t.vertex.z + 100};
    t.owned = below(64);
    return t;
  }

  std::mt19937 random_{5};

 private:
  uint32_t below(uint32_t end) { return static_cast<uint32_t>(random_()) % end; }
  float number(uint32_t end) { return static_cast<float>(below(end)); }
};

TEST_F(FeatureTests, AreThoseOfPlainBoxes) {
  uint32_t all = 0;
  for (int run = 0; run < 3000; ++run) {
    const auto a = triangle(), b = triangle();
    const uint32_t tests = FeatureRow(a.features()).tests(b.features());
    ASSERT_EQ(tests, plain_tests(a, b)) << run;
    all |= tests;
  }
  EXPECT_EQ(all, 0x3Fu | 0x777u << 6) << "each test came up";
}

TEST_F(FeatureTests, HaveOtherNumbersIfTheTrianglesChangePlaces) {
  for (int run = 0; run < 1000; ++run) {
    const auto a = triangle(), b = triangle();
    const uint32_t swapped = FeatureRow(b.features()).tests(a.features());
    uint32_t tests = 0;
    for (int test = 0; test < 17; ++test) tests |= (swapped >> test & 1) << test_of_swapped(test);
    ASSERT_EQ(tests, plain_tests(a, b)) << run;
  }
}

TEST_F(FeatureTests, NumberEdgesRowByRow) {
  for (int k = 0; k < 3; ++k)
    for (int m = 0; m < 3; ++m) {
      EXPECT_EQ(first_edge_of(6 + 4 * k + m), k);
      EXPECT_EQ(second_edge_of(6 + 4 * k + m), m);
    }
}

TEST_F(FeatureTests, WhatIsNotANumberKeepsNothingApart) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  BoxLanes<float> a, b;
  for (int lane = 0; lane < 4; ++lane) {
    a.set(lane, {{0, 0, 0}, {1, 1, 1}});
    b.set(lane, {{kNone, lane < 2 ? kNone : 2, 0}, {kNone, 3, 1}});
  }
  EXPECT_EQ(meeting_lanes(a, b), 3u);
  EXPECT_EQ(meeting_lanes(b, a), 3u);
}

}  // namespace
}  // namespace collided::test
