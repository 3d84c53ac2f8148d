// Cases of contacts that solvers rely on, row by row of one table; each test is named by its row. Scenes are F64 at
// EXACT. Boxes have 12 triangles, and the diagonals of opposite faces are parallel.
//
// Rows 1 to 12 are pairs of solids. So far their crossings alone are checked, in rows 25 and 26, as those of row 24
// are. Rows 22 and 23, sums of half thicknesses and a thick ball beside hair, are in half_thickness_test.cpp
// (LimitsAreRealSums) and thick_meshes_test.cpp (DoNotWidenThoseNearThem).

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/narrow/crossing_judge.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

using Triangles = std::vector<std::array<uint32_t, 3>>;

struct Shape {
  Positions positions;
  Triangles triangles;
};

// --- Shapes ---------------------------------------------------------------------------------------------------------

Shape box(const Vec3d& lo, const Vec3d& hi) {
  Shape box;
  for (uint32_t i = 0; i < 8; ++i)
    box.positions.push_back({i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2]});
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}
Shape unit_cube() { return box({0, 0, 0}, {1, 1, 1}); }

double volume6(const Positions& p) {
  double m[3][3];
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) m[i][k] = p[i + 1][k] - p[0][k];
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Its triangles face outward; the corners may come in any order.
Shape tetrahedron(Positions corners) {
  if (volume6(corners) < 0) std::swap(corners[0], corners[1]);
  return {corners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}
/// One of the two that are inscribed in the unit cube.
Shape inscribed(bool is_other) {
  Positions corners{{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  for (Vec3d& p : corners)
    if (is_other) p = {1 - p[0], 1 - p[1], 1 - p[2]};
  return tetrahedron(corners);
}

/// Around the z-axis.
Shape unit_ball(uint32_t bands, uint32_t sectors) {
  Shape ball{{{0, 0, 1}}, {}};
  for (uint32_t i = 1; i < bands; ++i)
    for (uint32_t j = 0; j < sectors; ++j) {
      const double down = std::numbers::pi * i / bands, around = 2 * std::numbers::pi * j / sectors;
      ball.positions.push_back({std::sin(down) * std::cos(around), std::sin(down) * std::sin(around), std::cos(down)});
    }
  ball.positions.push_back({0, 0, -1});
  const auto last = static_cast<uint32_t>(ball.positions.size() - 1);
  const auto at = [&](uint32_t i, uint32_t j) {
    return i == 0 ? 0 : i == bands ? last : 1 + (i - 1) * sectors + j % sectors;
  };
  for (uint32_t i = 0; i < bands; ++i)
    for (uint32_t j = 0; j < sectors; ++j) {
      if (i > 0) ball.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < bands) ball.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  return ball;
}

/// Every mesh is tested with the others, and not with itself.
Case apart(const std::vector<Shape>& shapes) {
  Case c;
  for (const Shape& shape : shapes) {
    add_mesh(c, shape.triangles, shape.positions);
    c.meshes.back().self_contacts = false;
  }
  return c;
}
Case alone(const Shape& shape) {
  Case c;
  add_mesh(c, shape.triangles, shape.positions);
  return c;
}

struct Row {
  std::string name;  ///< its number, and a letter where the row has several inputs
  Case input;
};

/// Rows 1 to 12.
std::vector<Row> pairs_of_solids() {
  const Shape second = box({-1, -1, 0}, {1, 1, 2});
  return {{"1", apart({box({-3, -1, 0}, {-1, 1, 2}), second})},
          {"2", apart({box({-3, -1, 0}, {-0.9, 1, 2}), second})},
          {"3", apart({box({-3, -1, 0}, {-1.1, 1, 2}), second})},
          {"4", apart({unit_cube(), box({.25, .25, .9}, {.75, .75, 2})})},
          {"5", apart({box({-3, -1, -1}, {3, 1, 1}), box({-1, -3, .5}, {1, 3, 3})})},
          {"6", apart({box({-3, -1, -1}, {3, 1, 1}), box({-1, -3, -1.5}, {1, 3, .5})})},
          {"7", apart({box({0, 0, 0}, {10, 10, 10}), box({4, 4, 4}, {5, 5, 5})})},
          {"8", apart({unit_cube(), unit_cube()})},
          {"9", apart({inscribed(false), inscribed(true)})},
          {"10", apart({unit_cube(), inscribed(false)})},
          {"11a", apart({unit_cube(), box({1, 1, 1}, {2, 2, 2})})},
          {"11b", apart({unit_cube(), box({1, 1, 0}, {2, 2, 1})})},
          {"12", apart({unit_ball(6, 8), box({-2, -.25, -.25}, {2, .25, .25})})}};
}

// --- Answers --------------------------------------------------------------------------------------------------------

SceneSpec exact_scene() {
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kExact);
  spec.kinds = {.edge_triangle = true};
  spec.fields = {ContactField::kElements, ContactField::kWeights, ContactField::kFlags};
  return spec;
}

/// An edge and a triangle by where their vertices were, whatever their ids are now.
using Crossing = std::array<uint32_t, 5>;

Crossing crossing_of(const Topology& topology, const std::array<uint32_t, 2>& elements,
                     const std::vector<uint32_t>& origin) {
  const auto& edge = topology.edges[elements[0]];
  const auto& triangle = topology.triangles[elements[1]];
  Crossing crossing{origin[edge[0]], origin[edge[1]], origin[triangle[0]], origin[triangle[1]], origin[triangle[2]]};
  std::sort(crossing.begin(), crossing.begin() + 2);
  std::sort(crossing.begin() + 2, crossing.end());
  return crossing;
}

struct Crossings {
  std::vector<Crossing> sure;  ///< no tie was broken; ascending
  size_t count = 0;            ///< all
  bool any_contact = false;
  std::map<PairKey, uint32_t> ends;  ///< of the contour, for each pair of triangles that has some
};

/// `origin` of each vertex of the case.
Crossings crossings_of(const Case& c, const std::vector<uint32_t>& origin) {
  const auto detector = Detector::create(spec_for(c, exact_scene()));
  const Topology& topology = detector->topology();
  const FrameResult result = detector->detect(Frame(c, Mode::kDcd, Scalar::kF64).input());
  Crossings found{
      {}, result.edge_triangle.size(), result.any_contact, contour_ends(result.edge_triangle.elements, topology)};
  for (size_t i = 0; i < found.count; ++i) {
    const auto& elements = result.edge_triangle.elements[i];
    if ((result.edge_triangle.flags[i] & kFlagTouching) == 0)
      found.sure.push_back(crossing_of(topology, elements, origin));
  }
  std::ranges::sort(found.sure);
  return found;
}
std::vector<uint32_t> in_order(const Case& c) {
  std::vector<uint32_t> origin(std::accumulate(c.meshes.begin(), c.meshes.end(), size_t{0},
                                               [](size_t n, const MeshSpec& mesh) { return n + mesh.vertex_count; }));
  std::iota(origin.begin(), origin.end(), 0u);
  return origin;
}
Crossings crossings_of(const Case& c) { return crossings_of(c, in_order(c)); }

void expect_two_ends(const Crossings& found) {
  for (const auto& [pair, ends] : found.ends)
    EXPECT_EQ(ends, 2u) << "triangles " << (pair >> 32) << " and " << static_cast<uint32_t>(pair);
}

template <class Random>
std::vector<uint32_t> shuffled(size_t count, Random& random) {
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::shuffle(order, random);
  return order;
}

/// The case with its meshes, their vertices and triangles in another order, and what each vertex was.
std::pair<Case, std::vector<uint32_t>> renumbered(const Case& c, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<uint32_t> begin(c.meshes.size() + 1, 0);
  for (size_t m = 0; m < c.meshes.size(); ++m) begin[m + 1] = begin[m] + c.meshes[m].vertex_count;
  Case out;
  std::vector<uint32_t> origin;
  for (const uint32_t m : shuffled(c.meshes.size(), random)) {
    const std::vector<uint32_t> was = shuffled(c.meshes[m].vertex_count, random);
    std::vector<uint32_t> now(was.size());
    Positions positions;
    for (uint32_t v = 0; v < was.size(); ++v) {
      now[was[v]] = v;
      positions.push_back(c.end[m][was[v]]);
      origin.push_back(begin[m] + was[v]);
    }
    Triangles triangles;
    for (const uint32_t t : shuffled(c.meshes[m].triangles.size(), random)) {
      auto corners = c.meshes[m].triangles[t];
      for (uint32_t& v : corners) v = now[v];
      std::ranges::rotate(corners, corners.begin() + random() % 3);
      triangles.push_back(corners);
    }
    add_mesh(out, triangles, positions);
    out.meshes.back().self_contacts = c.meshes[m].self_contacts;
  }
  return {out, origin};
}

/// Scales, then shifts.
Case moved(Case c, double scale, double by) {
  for (auto* meshes : {&c.start, &c.end})
    for (Positions& mesh : *meshes)
      for (Vec3d& p : mesh)
        for (double& x : p) x = x * scale + by;
  return c;
}

// --- Rows -----------------------------------------------------------------------------------------------------------

using ContactsTable = OnBackend<>;

TEST_F(ContactsTable, Row17NeighboursThatCross) {
  SceneSpec spec = exact_scene();
  spec.kinds.triangle_triangle = true;
  const Case c = alone({{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 1, -1}, {2, 1.5, 2}}, {{0, 1, 2}, {0, 3, 4}}});
  const FrameResult r = run_case(c, spec);
  ASSERT_EQ(r.edge_triangle.size(), 1u);
  const auto [w1, w2] = r.edge_triangle.weights[0];
  EXPECT_NEAR(4 * w1, 2, 1e-14);
  EXPECT_NEAR(4 * w2, 7.0 / 6, 1e-14);
  EXPECT_EQ(keys_of(r.triangle_triangle), std::vector<PairKey>{key_of(0, 1)});
  EXPECT_TRUE(r.any_contact);
}

TEST_F(ContactsTable, Row18TwoTrianglesFoldedFlat) {
  SceneSpec spec = exact_scene();
  spec.kinds = {.vertex_triangle = true, .edge_edge = true, .triangle_triangle = true, .edge_triangle = true};
  spec.fields = spec.fields.with(ContactField::kDistance);
  for (const Vec3d& tip :
       {Vec3d{0.25, 0.5, 0}, Vec3d{-3, 9, 0}, Vec3d{0, 1, 0}}) {  // within, around, and the same again
    const FrameResult r = run_case(alone({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, tip}, {{0, 1, 2}, {1, 0, 3}}}), spec);
    EXPECT_EQ(r.edge_triangle.size() + r.triangle_triangle.size(), 0u);
    EXPECT_GT(r.vertex_triangle.size() + r.edge_edge.size(), 0u);
    for (const ContactSet* set : {&r.vertex_triangle, &r.edge_edge})
      for (const double distance : set->distance) EXPECT_EQ(distance, 0);
  }
}

// Many pairs to a scene, far enough from each other; a pair's contours close whatever it looks like.
TEST_F(ContactsTable, Row24LatticeTetrahedra) {
  constexpr uint32_t kPairs = 10000, kInAScene = 200;
  std::mt19937 random(24);
  std::uniform_int_distribution<int> coordinate(0, 3);
  size_t crossing = 0, tied = 0;
  for (uint32_t first = 0; first < kPairs; first += kInAScene) {
    Shape shapes[2];
    for (uint32_t i = 0; i < kInAScene; ++i)
      for (Shape& shape : shapes) {
        Positions corners(4);
        do
          for (Vec3d& p : corners)
            for (double& x : p) x = coordinate(random);
        while (volume6(corners) == 0);
        Shape one = tetrahedron(corners);
        const auto base = static_cast<uint32_t>(shape.positions.size());
        for (Vec3d& p : one.positions) p[0] += 8 * i, shape.positions.push_back(p);
        for (auto& corner : one.triangles) {
          for (uint32_t& v : corner) v += base;
          shape.triangles.push_back(corner);
        }
      }
    const Crossings found = crossings_of(apart({shapes[0], shapes[1]}));
    expect_two_ends(found);
    crossing += found.ends.size(), tied += found.count - found.sure.size();
  }
  EXPECT_GT(crossing, size_t{kPairs});
  EXPECT_GT(tied, size_t{kPairs});
}

TEST_F(ContactsTable, Row25IdsShuffled) {
  for (const Row& row : pairs_of_solids()) {
    SCOPED_TRACE("row " + row.name);
    const Crossings expected = crossings_of(row.input);
    expect_two_ends(expected);
    EXPECT_EQ(expected.any_contact, row.name != "3" && row.name != "7");
    if (row.name == "5") {
      EXPECT_EQ(expected.count, 12u);
    }
    if (row.name == "7") {
      EXPECT_EQ(expected.count, 0u);
    }
    for (uint32_t seed = 0; seed < 12; ++seed) {
      const auto [c, origin] = renumbered(row.input, seed);
      const Crossings found = crossings_of(c, origin);
      expect_two_ends(found);
      EXPECT_EQ(found.sure, expected.sure);
      EXPECT_EQ(found.any_contact, expected.any_contact);
    }
  }
}

// Far from the origin and very small: the same pairs, and points where they were to the last bits.
TEST_F(ContactsTable, Row26FarAwayAndTiny) {
  const std::string exact_there[] = {"1", "5", "6", "8", "9", "10", "11a", "11b"};  // far away, too
  for (const Row& row : pairs_of_solids()) {
    if (!std::ranges::count(exact_there, row.name)) continue;
    SCOPED_TRACE("row " + row.name);
    const FrameResult expected = run_case(row.input, exact_scene());
    for (const Case& c : {moved(row.input, 1, 0x1p40), moved(row.input, 0x1p-300, 0)}) {
      const FrameResult found = run_case(c, exact_scene());
      EXPECT_EQ(keys_of(found.edge_triangle), keys_of(expected.edge_triangle));
      EXPECT_TRUE(std::ranges::equal(found.edge_triangle.flags, expected.edge_triangle.flags));
      EXPECT_EQ(found.any_contact, expected.any_contact);
      ASSERT_EQ(found.edge_triangle.weights.size(), expected.edge_triangle.weights.size());
      for (size_t i = 0; i < found.edge_triangle.size(); ++i)
        for (size_t k = 0; k < 2; ++k)
          EXPECT_NEAR(found.edge_triangle.weights[i][k], expected.edge_triangle.weights[i][k], 0x1p-47);
    }
  }
}

TEST_F(ContactsTable, Row27ClothBall92WithItself) {
  if (!are_here(kBallFrames)) GTEST_SKIP() << kNoDataFolder;
  Case c = load(kBallFrames);
  c.end = c.start;
  const JudgedCrossings judged = judge_crossings(Surface(c));
  const FrameResult r = run_case(c, exact_scene());
  EXPECT_EQ(keys_of(r.edge_triangle), judged.all());
  std::printf("cloth-ball 92: %zu crossings, %zu of them by the order of ids\n", judged.all().size(),
              judged.tied.size());
}

}  // namespace
}  // namespace collided::test
