// Poses found from positions.
#include "client/app/input/rigid_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace collided::cli {
namespace {

using Points = std::vector<scenes::Vec3d>;

Points turned(const Points& points, double angle, const scenes::Vec3d& shift) {
  Points out;
  for (const auto& [x, y, z] : points)
    out.push_back({std::cos(angle) * x - std::sin(angle) * y + shift[0],
                   std::sin(angle) * x + std::cos(angle) * y + shift[1], z + shift[2]});
  return out;
}

const Points kBody{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 1, 1}};

TEST(RigidMotion, IsThePoseThatPutsEveryVertexInPlace) {
  const Points now = turned(kBody, 0.7, {5, -6, 7});
  const client::RigidMatrix pose = pose_of("body", kBody, now);
  EXPECT_NEAR(pose[0], std::cos(0.7), 1e-12);
  EXPECT_NEAR(pose[4], std::sin(0.7), 1e-12);
  EXPECT_NEAR(pose[3], 5, 1e-12);
  EXPECT_NEAR(pose[11], 7, 1e-12);
}

TEST(RigidMotion, WhatBendsOrHasNoPoseIsRefused) {
  Points bent = kBody, mirrored = kBody;
  bent[3][2] += 1e-3;
  for (auto& p : mirrored) p[2] = -p[2];
  EXPECT_THROW(pose_of("body", kBody, bent), std::runtime_error);
  EXPECT_THROW(pose_of("body", kBody, mirrored), std::runtime_error);
  const Points line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, point{{1, 2, 3}};
  EXPECT_THROW(pose_of("line", line, line), std::runtime_error);
  EXPECT_THROW(pose_of("point", point, point), std::runtime_error);
}

}  // namespace
}  // namespace collided::cli
