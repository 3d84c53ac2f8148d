// How far a screw is from the straight path between its ends: never farther than what the engine adds, which is little
// more.

#include "gpu/positions/rigid_arc.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace collided::test {
namespace {

using Vec = Vec3<double>;
constexpr Box<double> kRest{{-1, -0.5, 2}, {1, 0.25, 3}};
constexpr double kUnit = 0x1p-53;

/// Turned by `angle` about the z axis through (x, y), and risen.
Pose screw(double angle, double x, double y, double rise) {
  const double c = std::cos(angle), s = std::sin(angle), half = std::sin(angle / 2), lost = 2 * half * half;  // 1 - c
  Pose pose;
  pose.rows = {c, -s, 0, lost * x + s * y, s, c, 0, lost * y - s * x, 0, 0, 1, rise};
  return pose;
}
Vec at(const Pose& pose, const Vec& p) {
  double rows[12];
  std::copy(pose.rows.begin(), pose.rows.end(), rows);
  return transformed(rows, p);
}

/// The largest distance of a vertex of the box from its straight path at the same time, of many times.
double largest_deviation(double angle, double x, double y, double rise) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec p{corner & 1 ? kRest.hi.x : kRest.lo.x, corner & 2 ? kRest.hi.y : kRest.lo.y,
                corner & 4 ? kRest.hi.z : kRest.lo.z};
    const Vec from = p, to = at(screw(angle, x, y, rise), p);
    for (int i = 1; i < 64; ++i) {
      const double t = i / 64.0;
      const Vec d = at(screw(angle * t, x, y, rise * t), p) - ((1 - t) * from + t * to);
      largest = std::max(largest, std::sqrt(dot(d, d)));
    }
  }
  return largest;
}

TEST(RigidArc, IsNeverLessThanTheDeviationAndLittleMore) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-5, 5), angles(0.01, 3);
  for (int i = 0; i < 500; ++i) {
    const double angle = angles(random), x = place(random), y = place(random), rise = place(random);
    const double bound = arc_deviation({}, screw(angle, x, y, rise), kRest, kUnit);
    const double deviation = largest_deviation(angle, x, y, rise);
    EXPECT_GE(bound, deviation) << angle;
    EXPECT_LE(bound, 1.25 * deviation) << angle;  // at 3 radians, angle^2 / 8 is 1.21 times 1 - cos(angle / 2)
  }
}

TEST(RigidArc, OfASmallTurnHoldsWhereverItsAxisIs) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-5, 5);
  for (const double angle : {1e-3, 1e-5, 1e-8, 1e-12}) {
    const double x = place(random) / angle, y = place(random) / angle;  // far off: nearly a translation
    EXPECT_GE(arc_deviation({}, screw(angle, x, y, 1), kRest, kUnit), largest_deviation(angle, x, y, 1)) << angle;
  }
}

TEST(RigidArc, IsNothingWithoutATurn) {
  Pose moved;
  moved.rows[3] = 7;
  EXPECT_EQ(0, arc_deviation({}, moved, kRest, kUnit));
  EXPECT_NEAR(2.5, angle_between({}, screw(2.5, 1, 1, 0)), 1e-14);
  EXPECT_LT(rotation_defect(screw(2.5, 1, 1, 0)), 1e-15);
}

TEST(RigidArc, CountsWhatIsNoRotation) {
  Pose stretched = screw(0.1, 0, 0, 0);
  for (const size_t i : {0, 1, 4, 5}) stretched.rows[i] *= 1 + 1e-5;
  EXPECT_GT(arc_deviation({}, stretched, kRest, kUnit), arc_deviation({}, screw(0.1, 0, 0, 0), kRest, kUnit) + 3e-5);
}

}  // namespace
}  // namespace collided::test
