// Whole steps of pairs that shorten their vertices' ways: no floor is missed at an end or on a way, nothing passes
// anything, whatever the order of pairs. Integer arithmetic decides.

#include "gpu/narrow/shortening.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/gpu/narrow/step_judge.hpp"
#include "tests/gpu/narrow/step_scenes.hpp"
#include "tests/support/verdicts/verdict_score_question.hpp"

namespace collided::test {
namespace {

constexpr FractionOf kFractionsOf[] = {FractionOf::kVertex, FractionOf::kMesh, FractionOf::kScene};

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

/// Two sheets, a cube over a sheet that stands, two balls over one, or a tetrahedron whose corner points at a sheet.
StepScene any_scene(int which, double gap) {
  StepScene scene;
  const auto add = [&](const Shape& shape, bool fixed = false) { scene.add(shape.vertices, shape.faces, fixed); };
  if (which == 0) add(sheet(4, 1, {0, 0, 0})), add(sheet(4, 1, {0.11, 0.07, gap}));
  if (which == 1) add(sheet(3, 2, {0, 0, 0}), true), add(cube(1, {0, 0, gap}));
  if (which == 2) {
    const Shape below = ball(0.5, {0, 0, 0});
    double lowest = 0, highest = 0;
    for (const Vec3d& v : below.vertices) lowest = std::min(lowest, v[2]), highest = std::max(highest, v[2]);
    add(below), add(ball(0.5, {0.01, 0, highest - lowest + gap})), add(sheet(3, 2, {0, 0, lowest - gap}));
  }
  if (which == 3) {
    add(sheet(4, 1, {0, 0, 0}));
    scene.add({{0.02, 0.01, gap}, {0.3, 0, 0.2}, {0, 0.3, 0.2}, {-0.2, 0, 0.3}},
              {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
  }
  return scene;
}

/// Where a solver might want them: meshes turned and moved, vertices shaken.
template <class Real>
std::vector<Vec3d> any_target(const StepScene& scene, const std::vector<Vec3d>& x, double size, Random& random) {
  const double way = size * std::pow(10.0, random.within(-6, -0.5));
  std::vector<Vec3d> p = x;
  if (random.chance(0.5))
    for (Vec3d& v : p) v = plus(v, random.vector(way));
  for (uint32_t mesh = 0; mesh < scene.is_static.size(); ++mesh) {
    const Turn turn(times(std::pow(10.0, random.within(-8, -0.5)), random.vector(1)));
    const Vec3d by = random.vector(way);
    if (!random.chance(0.7)) continue;
    const size_t first = static_cast<size_t>(std::ranges::find(scene.mesh, mesh) - scene.mesh.begin());
    for (size_t v = 0; v < p.size(); ++v)
      if (scene.mesh[v] == mesh) p[v] = plus(plus(turn(minus(p[v], x[first])), x[first]), by);
  }
  for (size_t v = 0; v < p.size(); ++v)
    if (scene.is_static[scene.mesh[v]]) p[v] = x[v];
  return rounded_to<Real>(p);
}

template <class Real>
void play(int which, uint64_t seed, uint32_t first_round, Findings& findings) {
  Random random(seed);
  // In F64 one in four nearly touches, so that many pairs are tiny.
  const bool nearly_touches = sizeof(Real) == 8 && random.chance(0.25);
  const double least = nearly_touches ? -13 : sizeof(Real) == 8 ? -8 : -5;
  const double gap = std::pow(10.0, random.within(least, nearly_touches ? -10 : -2));
  const double scale = std::exp2(random.integer(-20, 20));
  const double offset = random.chance(0.5) ? 0 : sizeof(Real) == 4 ? 4 : random.chance(0.5) ? 4 : 1024;
  StepScene scene = any_scene(which, gap);
  const Turn turn(random.vector(3));
  for (Vec3d& p : scene.positions) p = times(scale, plus(turn(p), {offset, 0.7 * offset, 0.3 * offset}));
  scene.positions = rounded_to<Real>(scene.positions);
  const double m = 1e-3 * scale;
  const FractionOf fraction_of = kFractionsOf[random.integer(0, 2)];
  SerialSteps<Real> steps(scene, m, fraction_of), shuffled(scene, m, fraction_of, seed + 1);
  steps.begin_with(first_round), shuffled.begin_with(first_round);
  std::vector<Vec3d> x = scene.positions;
  Findings before;
  judge_triangles_of(scene, x, before);
  if (before.crossed > 0) return;  // rounding closed the gap
  for (int step = 0; step < 3; ++step) {
    const std::vector<Vec3d> p = any_target<Real>(scene, x, scale, random);
    const StepResult result = steps.advance(x, p);
    if (step == 0) {
      const StepResult again = shuffled.advance(x, p);
      ASSERT_TRUE(same_bytes(result.y, again.y));
      ASSERT_TRUE(same_bytes(result.fractions, again.fractions));
      ASSERT_EQ(result.rounds, again.rounds);
    }
    judge_step(scene, steps, m, x, p, result, 60, random, findings);
    x = result.y;
  }
}

template <class Real>
void play_all(uint64_t first_seed, uint32_t first_round) {
  const uint64_t count = number_from_environment("COLLIDED_SHORTENED_SCENES", 12);
  static constexpr const char* kNames[] = {"sheets", "a cube on a sheet", "balls on a sheet", "a corner over a sheet"};
  for (int which = 0; which < 4; ++which) {
    Findings findings;
    for (uint64_t i = 0; i < count; ++i)
      play<Real>(which, first_seed + 4 * i + static_cast<uint64_t>(which), first_round, findings);
    findings.print(kNames[which]);
    findings.expect_none();
    EXPECT_GT(findings.ends, count);
    EXPECT_GT(findings.passages, 20 * count);
  }
}

// Later proposals are seldom needed. From them on everything has to hold as well.
class ShortenedSteps : public testing::TestWithParam<Shortening> {
 protected:
  static uint32_t first_round() {
    uint32_t round = 0;
    while (shortening_of(round) != GetParam()) ++round;
    return round;
  }
};

TEST_P(ShortenedSteps, KeepFloorsInF64) { play_all<double>(1, first_round()); }
TEST_P(ShortenedSteps, KeepFloorsInF32) { play_all<float>(1000001, first_round()); }

std::string name_of(const testing::TestParamInfo<Shortening>& info) {
  static constexpr const char* kNames[] = {"Times", "Planes", "Stand", "Islands"};
  return kNames[static_cast<size_t>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(From, ShortenedSteps,
                         testing::Values(Shortening::kTimes, Shortening::kPlanes, Shortening::kStand,
                                         Shortening::kIslands),
                         name_of);

}  // namespace
}  // namespace collided::test
