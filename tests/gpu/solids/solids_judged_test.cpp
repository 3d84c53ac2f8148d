// Vertices in solids, their depths, and how meshes lie to each other, against the judge: thousands of pairs of bodies
// on small lattices, where most ties happen, and the same turned, where most are nearly ties.

#include <cmath>

#include "tests/gpu/solids/judged_solids.hpp"

namespace collided::test {
namespace {

constexpr std::array kLevels = {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact};
constexpr double kSpacing = 8;  ///< of places far from each other: more than a body's size

Vec3d slot(int i) { return {kSpacing * (i % 23), kSpacing * (i / 23), 0}; }

/// A body and another one within a part of it, which chance seldom brings: the first or the second of them is around
/// the other one; it is in two parts at once; it is in a part that is inside out.
std::array<Body, 2> rare_pair(RandomBodies& random, int kind) {
  const Shape cube = box({0, 0, 0}, {4, 4, 4}), slab = box({0, 0, 0}, {3, 7, 7}), corner = box({4, 4, 4}, {7, 7, 7});
  if (kind == 0) return {Body{cube, {{cube}}}, moved(random.tetrahedron(2), {1, 1, 1})};
  if (kind == 1) return {moved(random.tetrahedron(2), {1, 1, 1}), Body{cube, {{cube}}}};
  if (kind == 2) return {Body{together(cube, slab), {{cube, slab}}}, moved(random.tetrahedron(1), {1, 1, 1})};
  return {Body{together(slab, reversed(corner)), {{slab}, {corner}}}, moved(random.tetrahedron(1), {5, 5, 5})};
}

/// Two bodies in each slot: most are solids, some are the same twice or no solid, some slots have three.
SolidsScene random_pairs(uint32_t seed, int slots) {
  RandomBodies random(seed);
  SolidsScene scene;
  for (int i = 0; i < slots; ++i) {
    if (i % 5 == 0) {
      for (const Body& body : rare_pair(random, i / 5 % 4)) add_solid(scene, moved(random.shuffled(body), slot(i)));
      continue;
    }
    const int size = 3 + random.below(2);
    const Body first = random.any(size);
    add_solid(scene, moved(random.shuffled(first), slot(i)));
    const int kind = random.below(20);
    if (kind == 0) add_solid(scene, moved(random.shuffled(first), slot(i)));
    if (kind > 0 && kind < 18) add_solid(scene, moved(random.shuffled(random.any(size)), slot(i)));
    if (kind < 17) continue;
    Positions positions;
    const MeshSpec loose = random.loose(size, positions);
    for (Vec3d& p : positions)
      for (size_t k = 0; k < 3; ++k) p[k] += slot(i)[k];
    add_surface(scene, loose, positions);
  }
  return scene;
}

/// About no axis.
Vec3d turned(const Vec3d& p) {
  const double a = 0.6, b = 1.1;
  const Vec3d q{std::cos(a) * p[0] - std::sin(a) * p[1], std::sin(a) * p[0] + std::cos(a) * p[1], p[2]};
  return {q[0], std::cos(b) * q[1] - std::sin(b) * q[2], std::sin(b) * q[1] + std::cos(b) * q[2]};
}

/// The point is straight below the inside of the triangle.
bool is_below(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  int left = 0, right = 0;
  for (size_t k = 0; k < 3; ++k) {
    const Vec3d &a = t[k], &b = t[(k + 1) % 3];
    const double side = (a[0] - p[0]) * (b[1] - p[1]) - (a[1] - p[1]) * (b[0] - p[0]);
    left += side > 0, right += side < 0;
  }
  return (left == 3 || right == 3) && std::min({t[0][2], t[1][2], t[2][2]}) > p[2];
}
/// Returns how many other solids are above a vertex, the most of all vertices.
int most_above(const Case& c) {
  int most = 0;
  for (size_t m = 0; m < c.meshes.size(); ++m)
    for (const Vec3d& p : c.end[m]) {
      int above = 0;
      for (size_t other = 0; other < c.meshes.size(); ++other)
        above +=
            other != m && c.meshes[other].solid && std::ranges::any_of(c.meshes[other].triangles, [&](const auto& t) {
              return is_below(p, {c.end[other][t[0]], c.end[other][t[1]], c.end[other][t[2]]});
            });
      most = std::max(most, above);
    }
  return most;
}

class SolidsJudged : public OnBackend<> {};

TEST_F(SolidsJudged, PairsOnLattices) {
  Tally tally;
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const JudgedScene scene(random_pairs(seed, 100));
    ASSERT_TRUE(scene.expect_at(Accuracy::kExact, Scalar::kF64, tally));
    ASSERT_TRUE(scene.expect_at(kLevels[seed % 4], seed % 8 < 4 ? Scalar::kF32 : Scalar::kF64, tally));
  }
  tally.print("lattices");
  tally.expect_all();
}

/// Numbers with a wide range, far from 0 and near it: the lattice stays one. Boxes are in float, so that all share one
/// where the lattice is far away.
TEST_F(SolidsJudged, LatticesFarAwayAndTiny) {
  constexpr std::pair<double, double> kPlaces[] = {{1, 0x1p40}, {0x1p-300, 0}, {0x1p-1073, 0}, {0x1p300, -0x1p30}};
  Tally tally;
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    const auto& [scale, by] = kPlaces[seed % std::size(kPlaces)];
    SCOPED_TRACE("scale " + std::to_string(std::log2(scale)) + " by " + std::to_string(by));
    const JudgedScene scene(placed(random_pairs(seed, 20), scale, by));
    for (const Accuracy accuracy : {Accuracy::kExact, Accuracy::kFast})
      ASSERT_TRUE(scene.expect_at(accuracy, Scalar::kF64, tally));
  }
  tally.print("far away and tiny");
  tally.expect_all();
}

/// Bodies of the same lattice turned and rounded: whatever touched is now a little apart or within.
TEST_F(SolidsJudged, TurnedLattices) {
  Tally tally;
  for (uint32_t seed = 1; seed <= 4; ++seed) {
    const Scalar scalar = seed % 2 == 0 ? Scalar::kF32 : Scalar::kF64;
    RandomBodies random(seed);
    SolidsScene scene;
    for (int i = 0; i < 60; ++i)
      for (int k = 0; k < 2; ++k) add_solid(scene, moved(random.shuffled(random.tetrahedron(3)), slot(i)));
    for (Positions& mesh : scene.c.end)
      for (Vec3d& p : mesh) p = turned(p);
    scene.c.start = scene.c.end;
    scene.c = rounded(scene.c, scalar);
    for (size_t m = 0; m < scene.pieces.size(); ++m)
      scene.pieces[m] = {{{scene.c.end[m], scene.c.meshes[m].triangles}}};
    const JudgedScene judged(std::move(scene));
    for (const Accuracy accuracy : kLevels) ASSERT_TRUE(judged.expect_at(accuracy, scalar, tally));
  }
  tally.print("turned");
  for (const uint64_t count : {tally.states[0], tally.states[1], tally.apart, tally.inside}) EXPECT_GT(count, 0u);
}

/// Rays that go up meet all solids of a column, which also reach into each other; all may touch but for masks. Their
/// windings are counted four at a time.
TEST_F(SolidsJudged, ColumnsAndMasks) {
  Tally tally;
  size_t excluded = 0;
  int above = 0;
  for (uint32_t seed = 1; seed <= 16; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomBodies random(seed);
    SolidsScene scene;
    const bool has_rules = seed % 2 == 0;
    for (int i = 0; i < 14; ++i) {
      add_solid(scene, moved(random.shuffled(random.any(3)), {0, 0, static_cast<double>(random.below(12))}));
      MeshSpec& mesh = scene.c.meshes.back();
      if (!has_rules) continue;
      mesh.groups = 1u << random.below(3), mesh.collide_mask = static_cast<uint32_t>(random.below(8));
      if (random.below(5) == 0) mesh.motion = MeshMotion::kStatic;
      if (random.below(6) == 0) mesh.solid = false, scene.pieces.back() = {};
      const auto other = static_cast<uint32_t>(random.below(i + 1));
      if (other < scene.c.meshes.size() - 1)
        scene.excluded.push_back({static_cast<uint32_t>(scene.c.meshes.size()) - 1, other});
    }
    excluded += scene.excluded.size();
    above = std::max(above, most_above(scene.c));
    const JudgedScene judged(std::move(scene));
    ASSERT_TRUE(judged.expect_at(kLevels[seed % 4], seed % 3 == 0 ? Scalar::kF32 : Scalar::kF64, tally));
  }
  EXPECT_GT(excluded, 40u);
  EXPECT_GT(above, 4);
  tally.print("columns");
  for (const uint64_t count : {tally.states[0], tally.states[1], tally.apart, tally.on, tally.inside})
    EXPECT_GT(count, 0u);
}

/// The first parts of both meshes are one cube. The others are one box too, which is inside out in the first mesh: its
/// volume is taken from the cube's.
TEST_F(SolidsJudged, VolumesThatCancel) {
  for (const double size : {0.5, 2.0}) {
    const Shape other = box({4, 0, 0}, {4 + size, 1, 1}), large = box({10, 0, 0}, {20, 1, 1});
    SolidsScene scene;
    add_solid(scene, {together(together(unit_cube(), large), reversed(other)), {}});
    add_solid(scene, {together(unit_cube(), other), {}});
    const FrameResult r = run_solids(scene, looking_into_solids(Accuracy::kExact, Scalar::kF64));
    ASSERT_EQ(r.pair_states.size(), 1u);
    EXPECT_EQ(r.pair_states[0].state, size < 1 ? PairState::kOverlapping : PairState::kTouching);
  }
}

}  // namespace
}  // namespace collided::test
