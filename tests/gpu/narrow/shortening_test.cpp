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

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
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

template <class Kind, class Real>
void count_planes(uint64_t seed) {
  constexpr size_t kFirst = DifferenceOf<Kind>::kOfFirst;
  constexpr QueryKind kKind = kFirst == 1 ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge;
  Random random(seed);
  int failed = 0, failed_again = 0;
  for (int i = 0; i < 20000; ++i) {
    const double gap = 1e-3 * random.within(0.5, 1.5), way_size = gap * std::exp2(random.integer(-20, 6));
    const Turn turn(random.vector(2));
    const Vec3d offset = random.vector(random.chance(0.5) ? 0 : 4);
    FeaturePoints<Real> way;
    const auto real = [](const Vec3d& p) {
      return Vec3<Real>{static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2])};
    };
    for (size_t v = 0; v < 4; ++v) {
      const Vec3d p = random.vector(1), q{p[0], p[1], v < kFirst ? gap : 0};
      way.start[v] = real(plus(offset, turn(q)));
      way.end[v] = real(plus(plus(offset, turn(q)), random.vector(way_size)));
    }
    const FloorRules rules{1e-3, 4};
    const StartDistance start = start_distance<Kind>(way, rules);
    const PairFloors floors = rules.floors_of<Real>(start, HUGE_VAL);
    if (keeps_floors<Kind>(way, floors) || start.value < floors.end + floors.noise * 0.99) continue;
    ++failed;
    const Shares shares = shares_of_failed<Kind>(way, floors, Shortening::kPlanes);
    for (size_t v = 0; v < 4; ++v) {
      const Vec3<Real> x = way.start[v], p = way.end[v];
      way.end[v] = {blend(x.x, p.x, shares.of[v]), blend(x.y, p.y, shares.of[v]), blend(x.z, p.z, shares.of[v])};
    }
    failed_again += !keeps_floors<Kind>(way, floors);
  }
  std::printf("%s in %s: %d failed, %d again\n", kKind == QueryKind::kEdgeEdge ? "edges" : "vertex and triangle",
              sizeof(Real) == 4 ? "F32" : "F64", failed, failed_again);
  EXPECT_EQ(failed_again, 0);
  EXPECT_GT(failed, 300);
}

// What planes part by more than its noise passes next time, so that rounds with planes end.
TEST(Planes, LetPairsPass) {
  count_planes<VertexTriangle, double>(1);
  count_planes<EdgeEdge, double>(2);
  count_planes<VertexTriangle, float>(3);
  count_planes<EdgeEdge, float>(4);
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
