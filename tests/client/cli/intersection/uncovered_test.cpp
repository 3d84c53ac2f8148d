#include "client/cli/intersection/uncovered.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace collided::cli {
namespace {

using Point = std::array<double, 3>;

bool has_area_in_any_order(const Point& a, const Point& b, const Point& c) {
  const bool has = has_area(a, b, c);
  for (const auto& [p, q, r] : {std::array{b, c, a}, {c, a, b}, {b, a, c}, {a, c, b}, {c, b, a}})
    EXPECT_EQ(has_area(p, q, r), has);
  return has;
}

TEST(HasArea, IsDecidedExactly) {
  EXPECT_TRUE(has_area_in_any_order({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(has_area_in_any_order({0, 0, 0}, {0, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(has_area_in_any_order({1, 2, 3}, {2, 4, 6}, {-1, -2, -3}));
  // Differences of these are rounded, and their products agree.
  const double tiny = 0x1p-60;
  EXPECT_FALSE(has_area_in_any_order({tiny, tiny, 0}, {1, 1, 0}, {3, 3, 0}));
  EXPECT_TRUE(has_area_in_any_order({tiny, 0, 0}, {1, 1, 0}, {3, 3, 0}));
}

TEST(HasArea, HoldsForNumbersOfAnySize) {
  const double least = std::numeric_limits<double>::denorm_min(), most = 0x1p1020;
  EXPECT_TRUE(has_area_in_any_order({0, 0, 0}, {least, 0, 0}, {0, least, 0}));
  EXPECT_FALSE(has_area_in_any_order({0, 0, 0}, {least, least, 0}, {3 * least, 3 * least, 0}));
  EXPECT_TRUE(has_area_in_any_order({0, 0, 0}, {most, most, 0}, {-most, -most, least}));
  EXPECT_FALSE(has_area_in_any_order({most, most, most}, {-most, -most, -most}, {least, least, least}));
  EXPECT_TRUE(has_area_in_any_order({most, most, most}, {-most, -most, -most}, {least, least, 0}));
}

TEST(UncoveredParts, AreNamedOnceEach) {
  const std::vector<Point> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {3, 0, 0}};
  const std::vector<std::array<uint32_t, 3>> triangles{{0, 1, 2}, {0, 1, 3}, {2, 0, 1}, {1, 0, 2}, {0, 3, 4}};
  const std::vector<std::array<uint32_t, 2>> edges{{0, 1}, {1, 2}};
  const std::vector<uint32_t> points{3};
  const client::MeshInput mesh{.vertex_count = 5, .triangles = triangles, .edges = edges, .points = points};
  EXPECT_EQ(uncovered_parts(mesh, positions),
            (std::vector<std::string>{"2 triangles without area, the first 1", "2 triangles listed again, the first 2",
                                      "3 loose edges and points"}));
  const client::MeshInput plain{.vertex_count = 5, .triangles = std::span(triangles).first(1)};
  EXPECT_TRUE(uncovered_parts(plain, positions).empty());
}

}  // namespace
}  // namespace collided::cli
