// Virtual subdivision: large triangles among small ones are found in pieces, and each pair is tested once.

#include <algorithm>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

SceneSpec settings_of(Engine engine, Mode mode = Mode::kDcd, double thickness = 0) {
  SceneSpec spec = settings(mode, Accuracy::kCandidates, Scalar::kF32, thickness);
  spec.engine = engine;
  return spec;
}

void add_triangle(Positions& positions, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  positions.insert(positions.end(), {a, b, c});
}
std::vector<std::array<uint32_t, 3>> separate(size_t positions) {
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t v = 0; v < positions; v += 3) triangles.push_back({v, v + 1, v + 2});
  return triangles;
}

/// Triangles of extent `size`, all of one shape, anywhere in the unit cube.
Positions equal_triangles(int count, double size) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0, 1 - size);
  Positions positions;
  for (int i = 0; i < count; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    add_triangle(positions, {x, y, z}, {x + size, y, z + size / 2}, {x, y + size, z + size});
  }
  return positions;
}
/// Triangles that cover half the side of the unit cube each, one above the other.
Positions floors(int count) {
  Positions positions;
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count;
    add_triangle(positions, {0, 0, z}, {1, 0, z}, {0, 1, z});
  }
  return positions;
}
Case case_with(const std::vector<Positions>& meshes) {
  Case c;
  for (const Positions& positions : meshes) add_mesh(c, separate(positions.size()), positions, positions);
  return rounded(c, Scalar::kF32);
}

/// Small triangles, and large ones of every kind among them: through everything, flat, without an area, in one place.
Case large_among_small() {
  Case c = soup(150, 1500, 1, 0.03, 0.02);
  const Case large = soup(151, 10, 1, 1.5, 0.1);
  add_mesh(c, large.meshes[0].triangles, large.start[0], large.end[0]);
  Positions others = floors(3), moved;
  add_triangle(others, {0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5});
  add_triangle(others, {0.2, 0.2, 0.2}, {0.2, 0.2, 0.2}, {0.2, 0.2, 0.2});
  for (int twin = 0; twin < 2; ++twin) add_triangle(others, {0, 0.3, 0.1}, {1, 0.3, 0.9}, {0.5, 0.9, 0.5});
  for (const Vec3d& p : others) moved.push_back({p[0], p[1], p[2] + 0.05});
  add_mesh(c, separate(others.size()), others, moved);
  c.name = "LargeAmongSmall";
  return rounded(c, Scalar::kF32);
}

using VirtualSubdivision = OnBackend<>;

TEST_F(VirtualSubdivision, FindsLargeTrianglesAmongSmallOnes) {
  const Case c = large_among_small();
  for (const Mode mode : {Mode::kCcd, Mode::kDcd}) {
    const double thickness = mode == Mode::kCcd ? 0 : 0.01;
    const FrameResult found = run_case(c, settings_of(Engine::kVss, mode, thickness));
    const ExpectedPairs expected = brute_force(c, mode, Scalar::kF32, thickness);
    EXPECT_EQ("", compare(found.vertex_triangle.elements, expected.vertex_triangle));
    EXPECT_EQ("", compare(found.edge_edge.elements, expected.edge_edge));
    EXPECT_TRUE(same_contacts(found, run_case(c, settings_of(Engine::kOctree, mode, thickness))));
  }
}

TEST_F(VirtualSubdivision, CellsDoNotGrowWithLargeTriangles) {
  const Case c = case_with({equal_triangles(2000, 0.05), floors(30)});
  const FrameResult uniform = run_case(c, settings_of(Engine::kUniformGrid)),
                    subdivided = run_case(c, settings_of(Engine::kVss));
  EXPECT_EQ(uniform.counts.base_level, 4u);
  EXPECT_EQ(subdivided.counts.base_level, 5u);  // 20 cells and more, for triangles of a twentieth
  EXPECT_GE(subdivided.counts.registrations, 30u * 10u * 10u) << "a floor is in pieces";
  EXPECT_LT(subdivided.counts.tests, uniform.counts.tests);
  EXPECT_EQ(subdivided.counts.pairs, uniform.counts.pairs);
  EXPECT_TRUE(same_contacts(subdivided, uniform));
}

TEST_F(VirtualSubdivision, IsTheUniformGridButForItsTestsWhereAllAreAsLarge) {
  const Case c = case_with({equal_triangles(2000, 0.05)});
  const FrameCounts uniform = run_case(c, settings_of(Engine::kUniformGrid)).counts,
                    subdivided = run_case(c, settings_of(Engine::kVss)).counts;
  EXPECT_EQ(subdivided.registrations, uniform.registrations);
  EXPECT_EQ(subdivided.leaves, uniform.leaves);
  EXPECT_LT(subdivided.tests, uniform.tests);
  EXPECT_GE(subdivided.tests, subdivided.pairs);
}

// In as many cells as they share.
TEST_F(VirtualSubdivision, TestsAPairOnce) {
  constexpr uint64_t kCount = 150;
  Positions same, far = floors(1);
  for (uint64_t i = 0; i < kCount; ++i) add_triangle(same, {0.1, 0.1, 0}, {0.4, 0.1, 0.2}, {0.1, 0.4, 0.3});
  for (Vec3d& p : far) p[2] += 1;  // in no cell with the others
  const Case c = case_with({same, far});
  const FrameCounts counts = run_case(c, settings_of(Engine::kVss)).counts;
  EXPECT_GT(counts.leaves, 1u);
  EXPECT_GT(counts.registrations, kCount);
  EXPECT_EQ(counts.tests, kCount * (kCount - 1) / 2);
  EXPECT_EQ(counts.pairs, counts.tests);
}

TEST_F(VirtualSubdivision, ABudgetThatIsTooSmallRefusesTheFrame) {
  const Case c = large_among_small();
  SceneSpec spec = spec_for(c, settings_of(Engine::kVss));
  const Frame frame(c, Mode::kDcd, Scalar::kF32);
  const auto unbounded = Detector::create(spec);
  unbounded->detect(frame.input());
  for (const MemoryPart& part : unbounded->memory())
    if (part.part != "answers" && part.part != "pinned") spec.memory_budget += part.bytes;  // those are the host's
  spec.memory_budget /= 2;
  EXPECT_THROW(Detector::create(spec)->detect(frame.input()), ResourceExhausted);
}

TEST_F(VirtualSubdivision, CanBeCancelledAtAnyTime) {
  const Case c = large_among_small();
  const auto detector = Detector::create(spec_for(c, settings_of(Engine::kVss, Mode::kCcd)));
  const Frame frame(c, Mode::kCcd, Scalar::kF32);
  const FrameResult expected = detector->detect(frame.input());
  FrameInput input = frame.input();
  int asked = 0, last = 0;
  input.cancelled = [&] { return asked++ >= last; };
  for (bool done = false; !done; asked = 0) {
    try {
      EXPECT_TRUE(same_contacts(expected, detector->detect(input)));
      done = true;
    } catch (const Cancelled&) {
      ASSERT_LT(last += 1 + last / 2, 100'000);
    }
  }
  EXPECT_GT(last, 2);
}

}  // namespace
}  // namespace collided::test
