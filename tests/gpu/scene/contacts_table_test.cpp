// Cases of contacts that solvers rely on, row by row of one table; each test is named by its row. Scenes are F64 at
// EXACT. Boxes have 12 triangles, and the diagonals of opposite faces are parallel.
//
// Rows 1 to 12 are pairs of solids. Their crossings are checked here, in rows 25 and 26, and the rest of what is told
// of them in solids_table_test.cpp, with rows 13 to 16 and 19b. Rows 22 and 23, sums of half thicknesses and a thick
// ball beside hair, are in half_thickness_test.cpp (LimitsAreRealSums) and thick_meshes_test.cpp
// (DoNotWidenThoseNearThem).

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/narrow/crossing_judge.hpp"
#include "tests/gpu/solid_shapes.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

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
Crossings crossings_of(const Case& c) { return crossings_of(c, in_order(c)); }

void expect_two_ends(const Crossings& found) {
  for (const auto& [pair, ends] : found.ends)
    EXPECT_EQ(ends, 2u) << "triangles " << (pair >> 32) << " and " << static_cast<uint32_t>(pair);
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
