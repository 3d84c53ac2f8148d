// Steps of what touches at the start: it may part, and nothing sinks in. Judged by the sides of whole bodies, in
// rational numbers, for a way between two triangles crosses neither.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/gpu/narrow/step_judge.hpp"
#include "tests/gpu/narrow/step_scenes.hpp"

namespace collided::test {
namespace {

constexpr double kM = 1e-3;

using Exact = std::array<mpq_class, 3>;
using Solid = std::array<Exact, 4>;  ///< the corners of a tetrahedron

Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
mpq_class dot(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
mpq_class volume(const Solid& s) { return dot(minus(s[1], s[0]), cross(minus(s[2], s[0]), minus(s[3], s[0]))); }

/// Whether a plane across n has both solids on its two sides; they may touch it.
bool parts(const Exact& n, const Solid& a, const Solid& b) {
  if (n[0] == 0 && n[1] == 0 && n[2] == 0) return false;
  const auto range = [&](const Solid& s) {
    std::array<mpq_class, 4> along;
    for (size_t i = 0; i < 4; ++i) along[i] = dot(n, s[i]);
    const auto [low, high] = std::ranges::minmax_element(along);
    return std::pair{*low, *high};
  };
  const auto of_a = range(a), of_b = range(b);
  return of_a.first >= of_b.second || of_b.first >= of_a.second;
}

/// Whether the solids have an inner point in common: neither a face nor two edges give a plane between them.
bool overlap(const Solid& a, const Solid& b) {
  std::vector<Exact> edges[2];
  for (const Solid* s : {&a, &b})
    for (size_t i = 0; i < 4; ++i)
      for (size_t j = i + 1; j < 4; ++j) edges[s == &b].push_back(minus((*s)[j], (*s)[i]));
  for (const auto& of_one : edges)
    for (const Exact& e : of_one)
      for (const Exact& f : of_one)
        if (parts(cross(e, f), a, b)) return false;
  for (const Exact& e : edges[0])
    for (const Exact& f : edges[1])
      if (parts(cross(e, f), a, b)) return false;
  return true;
}

/// The tetrahedra of a scene at a time of the way from x to y.
std::vector<Solid> solids_at(const std::vector<Vec3d>& x, const std::vector<Vec3d>& y, const mpq_class& time) {
  std::vector<Solid> solids(x.size() / 4);
  for (size_t v = 0; v < x.size(); ++v)
    for (size_t k = 0; k < 3; ++k) {
      const mpq_class from = x[v][k], to = y[v][k];
      solids[v / 4][v % 4][k] = from + time * (to - from);
    }
  return solids;
}

/// Whether no two overlap and none is turned inside out, which all were not at the start.
bool are_apart(const std::vector<Solid>& solids) {
  for (size_t i = 0; i < solids.size(); ++i) {
    if (volume(solids[i]) <= 0) return false;
    for (size_t j = 0; j < i; ++j)
      if (overlap(solids[i], solids[j])) return false;
  }
  return true;
}

bool touch(const Solid& a, const Solid& b) {
  for (size_t i = 0; i < 4; ++i)
    for (size_t j = 0; j < 4; ++j) {
      std::array<Vec3d, 3> f, g;
      for (size_t k = 1; k < 4; ++k)
        for (size_t c = 0; c < 3; ++c) f[k - 1][c] = a[(i + k) % 4][c].get_d(), g[k - 1][c] = b[(j + k) % 4][c].get_d();
      if (judge_triangles(f, g)) return true;
    }
  return false;
}

/// Tetrahedra with corners on a lattice, of which some touch and none overlap.
StepScene solids_on_a_lattice(Random& random) {
  for (;;) {
    StepScene scene;
    for (int body = random.integer(2, 4); body > 0; --body) {
      std::vector<Vec3d> corners;
      for (int i = 0; i < 4; ++i) corners.push_back(times(0.25, random.lattice(2)));
      if (volume(solids_at(corners, corners, 0)[0]) < 0) std::swap(corners[0], corners[1]);
      scene.add(corners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, random.chance(0.15));
    }
    const std::vector<Solid> solids = solids_at(scene.positions, scene.positions, 0);
    bool any_touch = false;
    for (size_t i = 0; i < solids.size(); ++i)
      for (size_t j = 0; j < i; ++j) any_touch = any_touch || touch(solids[i], solids[j]);
    if (any_touch && are_apart(solids)) return scene;
  }
}

/// Bodies moved, or their corners, by steps of a lattice or any.
std::vector<Vec3d> target_of(const StepScene& scene, const std::vector<Vec3d>& x, Random& random) {
  std::vector<Vec3d> p = x;
  const bool by_body = random.chance(0.6), on_lattice = random.chance(0.5);
  const auto any = [&] { return on_lattice ? times(0.0625, random.lattice(3)) : random.vector(0.2); };
  for (uint32_t body = 0; body < scene.is_static.size(); ++body) {
    const Vec3d of_body = any();
    for (size_t v = 4 * body; v < 4 * (body + 1); ++v)
      if (!scene.is_static[body]) p[v] = plus(p[v], by_body ? of_body : any());
  }
  return p;
}

TEST(TouchingStarts, OfSolidsOnALatticePartOrStand) {
  Random random(1);
  size_t pairs = 0, parted = 0, pressed = 0;
  for (int scene_number = 0; scene_number < 100; ++scene_number) {
    const StepScene scene = solids_on_a_lattice(random);
    SerialSteps<double> steps(scene, kM, kFractionsOf[random.integer(0, 2)]);
    std::vector<Vec3d> x = scene.positions;
    for (int step = 0; step < 2; ++step) {
      const std::vector<Vec3d> y = steps.advance(x, target_of(scene, x, random)).y;
      for (const auto& time : {mpq_class(1, 64), mpq_class(1, 3), mpq_class(2, 3), mpq_class(1)})
        ASSERT_TRUE(are_apart(solids_at(x, y, time))) << scene_number << ", step " << step;
      const std::vector<Solid> before = solids_at(x, x, 0), after = solids_at(y, y, 0);
      for (size_t i = 0; i < before.size(); ++i)
        for (size_t j = 0; j < i; ++j)
          if (touch(before[i], before[j])) ++pairs, ++(touch(after[i], after[j]) ? pressed : parted);
      x = y;
    }
  }
  std::printf("%zu pairs of bodies touched, %zu parted\n", pairs, parted);
  EXPECT_GT(parted, 30u);
  EXPECT_GT(pressed, 30u);
}

TEST(TouchingStarts, OfACubeLeaveTheFloorAndDoNotSink) {
  StepScene scene;
  scene.add({{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}}, {{0, 1, 2}, {0, 2, 3}}, true);
  add(scene, cube(1, {0.13, 0.21, 0}));
  for (const FractionOf fraction_of : kFractionsOf) {
    SerialSteps<double> steps(scene, kM, fraction_of);
    const auto p = moved_by(scene, scene.positions, 1, {0.01, 0.02, -0.003});
    const StepResult result = steps.advance(scene.positions, p);
    EXPECT_EQ(least_height(scene, result.y, 1), 0);
    for (const Vec3d& by : {Vec3d{0, 0, 0.01}, Vec3d{0.3, -0.2, 1e-3}, Vec3d{0, 0, 3}}) {
      const StepResult left = steps.advance(scene.positions, moved_by(scene, scene.positions, 1, by));
      EXPECT_EQ(least_of(left.fractions), 1);
      EXPECT_EQ(least_height(scene, left.y, 1), by[2]);
      Random random(1);
      Findings findings;
      judge_step(scene, steps, kM, scene.positions, left.y, left, ~size_t{0}, random, findings);
      findings.expect_none();
    }
  }
}

// A vertex of the floor under the cube's face has no side that anything tells.
TEST(TouchingStarts, OfFlatOnFlatStand) {
  const StepScene scene = cube_over_floor(0);
  for (const double up : {-0.01, 0.01}) {
    SerialSteps<double> steps(scene, kM, FractionOf::kMesh);
    EXPECT_EQ(steps.advance(scene.positions, moved_by(scene, scene.positions, 1, {0, 0, up})).y, scene.positions);
  }
}

// A coin lies on the bottom of a pit. A loose point lies on a triangle whose neighbour rises. The neighbours of a
// surface do not tell on which side of it something lies.
TEST(TouchingStarts, InAPitDoNotLeaveThroughTheBottom) {
  StepScene pit;
  pit.add({{0, 0, 0}, {12, 0, 0}, {0, 12, 0}, {12, 12, 6}}, {{0, 1, 2}, {1, 3, 2}}, true);
  pit.add({{3, 3, 0}}, {{0, 0, 0}});
  StepScene coin;
  const Shape box = cube(4, {0, 0, 0});
  std::vector<std::array<uint32_t, 3>> open = box.faces;
  open.erase(open.begin() + 2, open.begin() + 4);  // the upper face
  coin.add(box.vertices, open, true);
  add(coin, sheet(3, 1, {0, 0, 0}));
  for (StepScene* scene : {&pit, &coin})
    for (const double z : {-1.0, 1.0}) {
      SerialSteps<double> steps(*scene, kM, FractionOf::kVertex);
      EXPECT_EQ(steps.advance(scene->positions, moved_by(*scene, scene->positions, 1, {0, 0, z})).y, scene->positions);
    }
}

// Features that move by exactly the same vector need not part.
TEST(TouchingStarts, FallTogether) {
  StepScene scene;
  add(scene, sheet(3, 2, {0, 0, 0}));
  add(scene, cube(1, {0.125, 0.25, 0}));
  for (const FractionOf fraction_of : kFractionsOf) {
    SerialSteps<double> steps(scene, kM, fraction_of);
    std::vector<Vec3d> p = scene.positions;
    for (Vec3d& x : p) x[2] -= 0.25;
    EXPECT_EQ(steps.advance(scene.positions, p).y, p);
  }
}

/// A blade whose edge lies on the edge that two triangles share, or across it; they rise or fall beside it.
StepScene blade_on_an_edge(double slope, bool across) {
  StepScene scene;
  scene.add({{0, -1, 0}, {0, 1, 0}, {1, 0, slope}, {-1, 0, slope}}, {{0, 2, 1}, {0, 1, 3}}, true);
  if (across)
    scene.add({{-0.25, 0, 0}, {0.25, 0, 0}, {0, 0, 1}}, {{0, 1, 2}});
  else
    scene.add({{0, -0.5, 0}, {0, 0.5, 0}, {0, 0, 1}}, {{0, 1, 2}});
  return scene;
}

// In a hollow no plane parts it from both triangles.
TEST(TouchingStarts, OfBladesDoNotGoBetweenTwoTriangles) {
  for (const double slope : {0.0, -0.5, 0.25})
    for (const bool across : {false, true}) {
      if (across && slope > 0) continue;  // it would begin below
      const StepScene scene = blade_on_an_edge(slope, across);
      for (const FractionOf fraction_of : kFractionsOf) {
        SerialSteps<double> steps(scene, kM, fraction_of);
        for (const double aside : {0.0, 1e-12, 0.01}) {
          const auto p = moved_by(scene, scene.positions, 1, {aside, 0, -0.25});
          EXPECT_EQ(least_height(scene, steps.advance(scene.positions, p).y, 1), 0) << slope << across << aside;
          const auto up = moved_by(scene, scene.positions, 1, {aside, 0, 0.25});
          EXPECT_EQ(least_of(steps.advance(scene.positions, up).fractions), slope > 0 ? 0 : 1)
              << slope << across << aside;
        }
      }
    }
}

// A sheet that lies on another has no side.
TEST(TouchingStarts, OfSheetsOnEachOtherStand) {
  StepScene scene;
  add(scene, sheet(3, 2, {0, 0, 0}), true);
  add(scene, sheet(4, 1, {0.125, 0, 0}));
  for (const double z : {-0.1, 0.1}) {
    SerialSteps<double> steps(scene, kM, FractionOf::kVertex);
    const auto p = moved_by(scene, scene.positions, 1, {0, 0, z});
    EXPECT_EQ(steps.advance(scene.positions, p).y, scene.positions);
  }
}

}  // namespace
}  // namespace collided::test
