#include "client/cli/picture/view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace collided::cli {
namespace {

using scenes::Vec3d;

/// Column and row of a position, from the view's rays.
std::array<double, 2> seen_at(const View& view, const Vec3d& position) {
  const Vec3d way = scenes::minus(view.from_scene(position), view.eye());
  const Vec3d corner = view.direction(0, 0);
  const double right = way[0] / way[2], up = way[1] / way[2];
  const double left_edge = corner[0] / corner[2], upper_edge = corner[1] / corner[2];
  return {view.width() / 2.0 * (1 - right / left_edge), view.height() / 2.0 * (1 - up / upper_edge)};
}

std::vector<Vec3d> corners_of_a_box(const Vec3d& at, const Vec3d& extent) {
  std::vector<Vec3d> out;
  for (const double x : {0., extent[0]})
    for (const double y : {0., extent[1]})
      for (const double z : {0., extent[2]}) out.push_back(scenes::plus(at, {x, y, z}));
  return out;
}

TEST(View, TheAxesStandUprightAndLookWhereTheOptionsSay) {
  ViewOptions options{.azimuth = 0, .elevation = 0};
  const auto front = View::axes(options);
  EXPECT_EQ(front[0], (Vec3d{1, 0, 0}));
  EXPECT_EQ(front[1], (Vec3d{0, 0, 1}));
  EXPECT_EQ(front[2], (Vec3d{0, 1, 0}));
  options.elevation = 90;
  EXPECT_NEAR(View::axes(options)[2][2], -1, 1e-15);
  options = {.azimuth = 90, .elevation = 0, .is_y_up = true};
  EXPECT_EQ(View::axes(options)[1], (Vec3d{0, 1, 0}));
  EXPECT_NEAR(View::axes(options)[2][0], -1, 1e-15);
}

TEST(Framing, ShowsEverythingAsLargeAsItCan) {
  for (const double azimuth : {0., 30., 200.})
    for (const double elevation : {-90., -20., 0., 45., 90.})
      for (const auto& extent : {Vec3d{1, 1, 1}, Vec3d{100, 1, 0}, Vec3d{0, 0, 1e-6}, Vec3d{1e9, 2e9, 1e9}})
        for (const Vec3d& at : {Vec3d{0, 0, 0}, Vec3d{1e4, -1e4, 1e4}}) {
          const ViewOptions options{.azimuth = azimuth, .elevation = elevation, .width = 300, .height = 200};
          Framing framing(options);
          for (const Vec3d& corner : corners_of_a_box(at, extent)) framing.add(corner);
          const View view = framing.view();
          double rim = 1e9;
          for (const Vec3d& corner : corners_of_a_box(at, extent)) {
            const auto [column, row] = seen_at(view, corner);
            rim = std::min({rim, column / 300, 1 - column / 300, row / 200, 1 - row / 200});
            EXPECT_GT(scenes::minus(view.from_scene(corner), view.eye())[2], 0);
          }
          EXPECT_GE(rim, 0.029) << azimuth << " " << elevation << " " << extent[0] << " " << at[0];
          const bool is_seen_as_a_point = extent[0] == 0 && std::abs(elevation) == 90;
          EXPECT_EQ(rim < 0.031, !is_seen_as_a_point)
              << azimuth << " " << elevation << " " << extent[0] << " " << at[0];
        }
}

TEST(Framing, OnePointAndNoneHaveAView) {
  Framing framing({});
  EXPECT_TRUE(framing.is_empty());
  EXPECT_GT(framing.view().middle_pixel(), 0);
  framing.add({1, 2, 3});
  EXPECT_EQ(framing.size(), 0);
  const auto [column, row] = seen_at(framing.view(), {1, 2, 3});
  EXPECT_NEAR(column, 600, 1e-6);
  EXPECT_NEAR(row, 450, 1e-6);
}

TEST(Framing, ASceneThatIsTooLargeIsRefused) {
  for (const double far : {1e101, 1e200, 1e307}) {
    Framing framing({});
    framing.add({0, 0, 0});
    framing.add({far, 0, 0});
    EXPECT_THROW(framing.view(), std::runtime_error) << far;
  }
  Framing tiny({});
  tiny.add({0, 0, 0});
  tiny.add({1e-300, 0, 0});
  EXPECT_TRUE(std::isfinite(tiny.view().from_scene({1e-300, 0, 0})[0]));
}

TEST(Framing, AMarginShowsMore) {
  Framing framing({});
  framing.add({-1, -1, -1});
  framing.add({1, 1, 1});
  const View near = framing.view(), far = framing.view(2);
  EXPECT_LT(seen_at(near, {1, 1, 1})[1], seen_at(far, {1, 1, 1})[1]);
}

}  // namespace
}  // namespace collided::cli
