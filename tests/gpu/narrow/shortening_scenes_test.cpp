// Steps of scenes whose outcome is known: what rests, slides, rolls along and parts is free, what is pressed stays
// where it may.

#include <gtest/gtest.h>

#include "tests/gpu/narrow/step_judge.hpp"
#include "tests/gpu/narrow/step_scenes.hpp"

namespace collided::test {
namespace {

constexpr double kM = 1e-3;

TEST(FreeSteps, OfWhatSlidesOnATiltedFloor) {
  for (const double gap : {1e-8, 1e-6, kM / 2, kM}) {
    StepScene scene = cube_over_floor(gap);
    const Turn tilt({0.28, 0.1, 0.05});
    for (Vec3d& p : scene.positions) p = tilt(p);
    Random random(1);
    Findings findings;
    for (const FractionOf fraction_of : kFractionsOf) {
      SerialSteps<double> steps(scene, kM, fraction_of);
      std::vector<Vec3d> x = scene.positions;
      for (int step = 0; step < 8; ++step) {
        const std::vector<Vec3d> p = moved_by(scene, x, 1, tilt({step % 2 == 0 ? 0.11 : -0.3, 0.07, 0}));
        const StepResult result = steps.advance(x, p);
        EXPECT_EQ(least_of(result.fractions), 1) << gap;
        judge_step(scene, steps, kM, x, p, result, 40, random, findings);
        x = result.y;
      }
    }
    findings.expect_none();
  }
}

TEST(FreeSteps, OfWhatParts) {
  for (const double gap : {1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, kM}) {
    const StepScene scene = cube_over_floor(gap);
    for (const FractionOf fraction_of : kFractionsOf) {
      SerialSteps<double> steps(scene, kM, fraction_of);
      const auto p = moved_by(scene, scene.positions, 1, {0, 0, 0.01});
      EXPECT_EQ(least_of(steps.advance(scene.positions, p).fractions), 1) << gap;
    }
  }
}

TEST(FreeSteps, OfSheetsThatTurnTogether) {
  for (const double gap : {1e-8, kM / 2, kM})
    for (const double angle : {1e-8, 1e-7, 1e-4, 1e-2, 0.1, 0.5}) {
      if (gap == 1e-8 && angle > 0.05) continue;  // chords of edges that are parallel at one time only
      StepScene scene;
      add(scene, sheet(4, 1, {0, 0, 0}));
      add(scene, sheet(4, 1, {0, 0, gap}));
      const Turn tilt({0.05, 0.3, 0.1}), turn({angle, 0, 0});
      for (Vec3d& p : scene.positions) p = tilt(p);
      for (const FractionOf fraction_of : kFractionsOf) {
        SerialSteps<double> steps(scene, kM, fraction_of);
        std::vector<Vec3d> x = scene.positions;
        for (int step = 0; step < 3; ++step) {
          std::vector<Vec3d> p = x;
          for (Vec3d& v : p) v = turn(v);
          const StepResult result = steps.advance(x, p);
          EXPECT_EQ(least_of(result.fractions), 1) << "gap " << gap << ", angle " << angle << ", step " << step;
          x = result.y;
        }
      }
    }
}

TEST(FreeSteps, OfWhatFallsOrIsPushedTogether) {
  for (const double gap : {1e-8, kM / 2, kM}) {
    StepScene scene;
    add(scene, cube(1, {0, 0, 0}));
    add(scene, cube(1, {0.2, 0.1, 1 + gap}));
    for (const FractionOf fraction_of : kFractionsOf) {
      SerialSteps<double> steps(scene, kM, fraction_of);
      std::vector<Vec3d> x = scene.positions;
      for (int step = 0; step < 5; ++step) {
        std::vector<Vec3d> p = x;
        for (Vec3d& v : p) v = plus(v, {0.01, 0.02, -0.1});
        const StepResult result = steps.advance(x, p);
        EXPECT_EQ(least_of(result.fractions), 1) << gap;
        x = result.y;
      }
    }
  }
}

// A corner passes another one at a distance that both ends of the way say nothing of.
TEST(FlyBys, KeepSevenEighthsOnTheWay) {
  Random random(9);
  Findings findings;
  size_t free = 0, stopped = 0, between = 0;
  for (int i = 0; i < 300; ++i) {
    const double height = kM * (random.chance(0.5) ? random.within(0.3, 0.874) : random.within(0.876, 1.3));
    const std::vector<std::array<uint32_t, 3>> faces{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    StepScene scene;
    scene.add({{0, 0, 0}, {-0.1, -0.2, -0.3}, {0.2, -0.1, -0.3}, {0, 0.2, -0.3}}, faces, true);
    const double from = random.within(-0.6, -0.2);
    scene.add({{from, 0, height}, {from, -0.02, 0.1}, {from, 0.02, 0.1}, {from - 0.02, 0, 0.1}}, faces);
    const Turn tilt(random.vector(2));
    for (Vec3d& p : scene.positions) p = tilt(p);
    const auto p = moved_by(scene, scene.positions, 1, tilt({1, 0, 0}));
    SerialSteps<double> steps(scene, kM, kFractionsOf[i % 3]);
    const StepResult result = steps.advance(scene.positions, p);
    judge_step(scene, steps, kM, scene.positions, p, result, ~size_t{0}, random, findings);
    const bool is_free = least_of(result.fractions) == 1;
    free += is_free, stopped += !is_free, between += height > 7.0 / 8 * kM && height < kM;
    EXPECT_EQ(is_free, height > 0.875 * kM) << height;
  }
  std::printf("%zu passed by, %zu stopped, %zu at between 7/8 and 1 of the minimum separation\n", free, stopped,
              between);
  findings.expect_none();
}

TEST(PressedSteps, EndAtTheirFloorsAndPartAgain) {
  for (const double gap : {1e-8, 1e-6, kM / 2, kM, 0.0123}) {
    const StepScene scene = cube_over_floor(gap);
    for (const FractionOf fraction_of : kFractionsOf) {
      SerialSteps<double> steps(scene, kM, fraction_of);
      std::vector<Vec3d> x = scene.positions;
      for (int step = 0; step < 20; ++step) x = steps.advance(x, moved_by(scene, x, 1, {0, 0, -0.004})).y;
      const double lost = 20 * 4 * 0x1p-45;
      EXPECT_GE(least_height(scene, x, 1), std::min(gap, kM) - lost);
      EXPECT_LE(least_height(scene, x, 1), std::min(gap, 1.05 * kM));
      EXPECT_EQ(least_of(steps.advance(x, moved_by(scene, x, 1, {0, 0, 0.05})).fractions), 1);
    }
  }
}

TEST(PressedSteps, WithoutMinimumSeparationDoNotTouch) {
  const StepScene scene = cube_over_floor(0.01);
  SerialSteps<double> steps(scene, 0, FractionOf::kVertex);
  std::vector<Vec3d> x = scene.positions;
  for (int step = 0; step < 12; ++step) x = steps.advance(x, moved_by(scene, x, 1, {0, 0, -0.004})).y;
  EXPECT_GT(least_height(scene, x, 1), 0);
  EXPECT_LT(least_height(scene, x, 1), 1e-8);
  EXPECT_EQ(least_of(steps.advance(x, moved_by(scene, x, 1, {0.05, 0.03, 0})).fractions), 1);
  EXPECT_EQ(least_of(steps.advance(x, moved_by(scene, x, 1, {0, 0, 0.05})).fractions), 1);
}

// Tests of a single triangle over another, for very many steps.
StepScene triangle_over_triangle() {
  StepScene scene;
  scene.add({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, true);
  scene.add({{0.2, 0.2, 0.005}, {0.3, 0.2, 0.5}, {0.2, 0.3, 0.5}}, {{0, 1, 2}});
  return scene;
}

template <class Real>
double height_after_steps(double m, double noise_share, int count) {
  StepScene scene = triangle_over_triangle();
  scene.positions = rounded_to<Real>(scene.positions);
  SerialSteps<Real> steps(scene, m, FractionOf::kVertex);
  std::vector<Vec3d> x = scene.positions;
  for (int step = 0; step < count; ++step) {
    const double down = noise_share * PositionNoise<Real>::kOfFloor;
    x = steps.advance(x, rounded_to<Real>(moved_by(scene, x, 1, {0, 0, -down}))).y;
  }
  return least_height(scene, x, 1);
}

TEST(ManySteps, CreepNoFartherThanTheirRow) {
  constexpr double kRow = 45.0 / 64 * 0.01 / 2;
  const double in_float = height_after_steps<float>(0.01, 0.2, 20000);
  const double in_double = height_after_steps<double>(0.01, 0.45, 20000);
  std::printf("20,000 steps, each pressed by a part of its noise: 0.005 to %.7f in F32, to 0.005 - %.3g in F64\n",
              in_float, 0.005 - in_double);
  EXPECT_GE(in_float, kRow);
  EXPECT_LT(in_float, 0.0049);
  EXPECT_GE(in_double, 0.005 - 20000 * 0x1p-45);
}

// The case advance_creeps: pressed by far more than noise.
TEST(ManySteps, PressedHardStayWhereTheyAre) {
  StepScene scene = triangle_over_triangle();
  SerialSteps<double> steps(scene, 0.01, FractionOf::kScene);
  std::vector<Vec3d> x = scene.positions;
  for (int step = 0; step < 20000; ++step)
    x = steps.advance(x, moved_by(scene, x, 1, {0, 0, -x[3][2] * 0.9 * 0x1p-20})).y;
  EXPECT_GE(x[3][2], 0.005 * (1 - 1e-9));
}

// A bad start on a large static triangle costs others on it nothing.
TEST(Clearances, OfAStaticVertexCountForOneOtherMesh) {
  for (const double gap : {0.0, 1e-6, kM}) {
    StepScene scene;
    scene.add({{-5, -5, 0}, {5, -5, 0}, {-5, 5, 0}, {5, 5, 0}}, {{0, 1, 2}, {1, 3, 2}}, true);
    add(scene, cube(1, {-1.5, 0, gap}));
    add(scene, cube(1, {1.5, 0, 0.01}));
    SerialSteps<double> steps(scene, kM, FractionOf::kVertex);
    std::vector<Vec3d> x = scene.positions;
    for (int step = 0; step < 30; ++step) x = steps.advance(x, moved_by(scene, x, 2, {0, 0, -0.004})).y;
    EXPECT_GE(least_height(scene, x, 2), kM) << gap;
    EXPECT_LT(least_height(scene, x, 2), 1.05 * kM) << gap;
  }
}

/// A blade over the edge that two triangles share, a loose edge and a loose point beside it, and a hair over them.
StepScene tips(double gap) {
  StepScene scene;
  scene.add({{0, -1, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}}, {{0, 2, 1}, {0, 1, 3}}, true);
  scene.add({{0, -0.5, gap}, {0, 0.5, gap}, {0, 0, 1}}, {{0, 1, 2}});
  scene.add({{0.3, 0.1, gap}, {0.4, 0.2, gap}}, {{0, 1, 1}});
  scene.add({{-0.3, 0.05, gap}}, {{0, 0, 0}});
  scene.add({{0.31, 0.1, 2 * gap + 1e-4}, {0.35, 0.2, 2 * gap + 1e-4}}, {{0, 1, 1}});
  return scene;
}

TEST(PressedSteps, OfBladesLooseEdgesAndPointsDoNotSink) {
  for (const double gap : {1e-11, 1e-9, 1e-7, 1e-5})
    for (const FractionOf fraction_of : kFractionsOf) {
      const StepScene scene = tips(gap);
      SerialSteps<double> steps(scene, kM, fraction_of);
      std::vector<Vec3d> x = scene.positions;
      const auto all_moved = [&](double by) {
        std::vector<Vec3d> p = x;
        for (size_t v = 4; v < p.size(); ++v) p[v][2] += by;
        return p;
      };
      Random random(1);
      Findings findings;
      for (int step = 0; step < 15; ++step) {
        const auto p = all_moved(-0.01);
        const StepResult result = steps.advance(x, p);
        judge_step(scene, steps, kM, x, p, result, 20, random, findings);
        x = result.y;
      }
      findings.expect_none();
      for (const uint32_t mesh : {1, 2, 3, 4})
        EXPECT_GE(least_height(scene, x, mesh), gap - 15 * 0x1p-45) << gap << ", mesh " << mesh;
      EXPECT_EQ(least_of(steps.advance(x, all_moved(0.01)).fractions), 1);
    }
}

// Each round stops one more, until islands do. Only planes leave room for what is less than noise.
TEST(Rounds, EndInAColumnWhereEachBlocksTheNext) {
  for (const auto& [count, rounds] : {std::pair{30u, 29u}, std::pair{150u, 97u}}) {
    StepScene scene;
    for (uint32_t i = 0; i < count; ++i) {
      const Turn turn({0, 0, 0.3 * i});
      std::vector<Vec3d> triangle{{-0.5, -0.5, i * kM}, {0.5, -0.5, i * kM}, {0, 0.6, i * kM}};
      for (Vec3d& p : triangle) p = turn(p);
      scene.add(triangle, {{0, 1, 2}}, i == 0);
    }
    std::vector<Vec3d> p = scene.positions;
    for (size_t v = 3; v < p.size(); ++v) p[v][2] -= kM / 2;
    SerialSteps<double> steps(scene, kM, FractionOf::kMesh);
    const StepResult result = steps.advance(scene.positions, p);
    EXPECT_EQ(result.rounds, rounds);
    EXPECT_LT(*std::max_element(result.fractions.begin() + 3, result.fractions.end()), 1e-10);
    Random random(1);
    Findings findings;
    judge_step(scene, steps, kM, scene.positions, p, result, 200, random, findings);
    findings.expect_none();
  }
}

}  // namespace
}  // namespace collided::test
