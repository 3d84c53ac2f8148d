// Scenes of mixed scale, whose crowded cells are refined below the octree's dense levels: the same contacts, and tests
// where there is something to find.

#include <algorithm>
#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kCluster = 3000;  // 1,500 tests a triangle if they all share a cell; from 512 on it is refined
constexpr uint64_t kAllPairs = uint64_t{kCluster} * (kCluster - 1) / 2;

/// Left to itself, a scene of mixed scale would go on with the hierarchy.
SceneSpec candidates(Scalar scalar) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCandidates, scalar);
  spec.engine = Engine::kOctree;
  return spec;
}

bool is_refined(const FrameResult& result) {
  return std::any_of(result.stages.begin(), result.stages.end(),
                     [](const StageTime& stage) { return stage.stage == "refine"; });
}

void add_soup(Case& c, uint32_t seed, uint32_t count, double side, double size, const Vec3d& centre = {}) {
  const Case part = soup(seed, count, side, size, size / 10, centre);
  add_mesh(c, part.meshes[0].triangles, part.start[0], part.end[0]);
}

/// A detector, and the first and the later frames of a case.
class Scene {
 public:
  Scene(const Case& c, const SceneSpec& settings) : spec_(spec_for(c, settings)), detector_(Detector::create(spec_)) {}
  FrameResult play(const Case& c) {
    const Frame frame(c, spec_.mode, spec_.scalar);
    return detector_->detect(frame.input());
  }

 private:
  SceneSpec spec_;
  std::unique_ptr<Detector> detector_;
};

void expect_pairs(const FrameResult& result, const ExpectedPairs& expected) {
  EXPECT_EQ("", compare(result.vertex_triangle.elements, expected.vertex_triangle)) << "vertex-triangle";
  EXPECT_EQ("", compare(result.edge_edge.elements, expected.edge_edge)) << "edge-edge";
}

constexpr int kFirstFrames = 8;  // in which the levels find to what the scene needs

/// Plays a case that stands still, each frame against brute force; returns the last frame.
FrameResult play_against_brute_force(const Case& exact, Scalar scalar) {
  const Case c = rounded(exact, scalar);
  const ExpectedPairs expected = brute_force(c, Mode::kCcd, scalar, 0);
  EXPECT_GT(expected.vertex_triangle.must.size(), 0u);
  Scene scene(c, candidates(scalar));
  FrameResult last;
  bool refined = false;
  for (int frame = 0; frame < kFirstFrames + 4; ++frame) {
    SCOPED_TRACE(frame);
    last = scene.play(c);
    expect_pairs(last, expected);
    refined = refined || is_refined(last);
    if (frame >= kFirstFrames) {
      EXPECT_EQ(last.replays, 0u) << "nothing changed";
    }
  }
  EXPECT_TRUE(refined) << "the scene is too small";
  return last;
}

/// A cluster of size 1 and one triangle far away.
Case cluster_and(double distance) {
  Case c = soup(220, kCluster, 1, 0.05, 0.005);
  const double d = distance;
  add_mesh(c, {{0, 1, 2}}, {{d, d, d}, {d * 1.001, d, d}, {d, d * 1.001, d}});
  return c;
}

class FarTriangle : public OnBackend<::testing::TestWithParam<std::tuple<double, Scalar>>> {
 protected:
  double distance() const { return std::get<0>(GetParam()); }
  Scalar scalar() const { return std::get<1>(GetParam()); }
};
// The levels end at 2^19 cells a side: at the largest distance the cluster is in one cell whatever is done.
class FarthestTriangle : public FarTriangle {};

TEST_P(FarTriangle, ChangesNoContact) { play_against_brute_force(cluster_and(distance()), scalar()); }
TEST_P(FarthestTriangle, ChangesNoContact) { play_against_brute_force(cluster_and(distance()), scalar()); }

TEST_P(FarTriangle, CostsFewTestsAfterTheFirstFrames) {
  const Case c = rounded(cluster_and(distance()), scalar());
  Scene scene(c, candidates(scalar()));
  for (int frame = 0; frame < kFirstFrames; ++frame) scene.play(c);
  for (int frame = 0; frame < 4; ++frame) EXPECT_LT(scene.play(c).counts.tests, kAllPairs / 10);
}

TEST_P(FarTriangle, CostsFewTestsAtOnce) {
  const Case c = rounded(cluster_and(distance()), scalar());
  const FrameResult first = Scene(c, candidates(scalar())).play(c);
  EXPECT_GT(first.replays, 0u);
  EXPECT_LT(first.counts.tests, kAllPairs / 10);
}

constexpr auto kDistanceName = [](const auto& info) {
  return "Ten" + std::to_string(std::lround(std::log10(std::get<0>(info.param)))) +
         (std::get<1>(info.param) == Scalar::kF32 ? "F32" : "F64");
};
INSTANTIATE_TEST_SUITE_P(Distances, FarTriangle,
                         ::testing::Combine(::testing::Values(1e3, 1e5), ::testing::Values(Scalar::kF32, Scalar::kF64)),
                         kDistanceName);
INSTANTIATE_TEST_SUITE_P(Distances, FarthestTriangle,
                         ::testing::Combine(::testing::Values(1e7), ::testing::Values(Scalar::kF32, Scalar::kF64)),
                         kDistanceName);

class MixedScale : public OnBackend<::testing::TestWithParam<Scalar>> {};

// Each scale is a hundredth of the next. Many enough at each that the crowd is refined again and again.
TEST_P(MixedScale, ClustersWithinClusters) {
  Case c = soup(221, 800, 1e4, 500, 10);
  for (const double side : {100.0, 1.0, 0.1}) add_soup(c, 222, 1600, side, side / 15);
  const FrameResult last = play_against_brute_force(c, GetParam());
  EXPECT_TRUE(is_refined(last));
  EXPECT_LT(last.counts.tests, 5600u * 5599u / 2 / 10);
}

// A dozen triangles cover all cells; clusters lie between them.
TEST_P(MixedScale, HugeTrianglesOverClusters) {
  Case c = soup(223, kCluster, 1, 0.05, 0.005);
  add_soup(c, 224, 12, 1, 200);
  add_soup(c, 225, 1200, 0.2, 0.01, {30, 20, -10});
  const FrameResult last = play_against_brute_force(c, GetParam());
  EXPECT_TRUE(is_refined(last));
  EXPECT_LT(last.counts.tests, kAllPairs / 5);
}

INSTANTIATE_TEST_SUITE_P(Scalars, MixedScale, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

/// Two meshes of a cluster that may touch each other but not themselves, so that the many pairs of boxes stay few.
Case two_groups(Case cluster, uint32_t seed) {
  cluster.meshes[0].self_contacts = false;
  add_soup(cluster, seed, 5, 0.1, 0.1);
  return cluster;
}

using Refinement = OnBackend<>;

// Refinement tries, finds that it is no use, and leaves it for a good while.
void expect_right_and_rarely_replayed(const Case& exact) {
  const Case c = rounded(exact, Scalar::kF32);
  const ExpectedPairs expected = brute_force(c, Mode::kCcd, Scalar::kF32, 0);
  ASSERT_GT(expected.edge_edge.must.size(), 0u);
  Scene scene(c, candidates(Scalar::kF32));
  uint32_t replayed = 0;
  bool refined = false;
  for (int frame = 0; frame < 40; ++frame) {
    SCOPED_TRACE(frame);
    const FrameResult result = scene.play(c);
    expect_pairs(result, expected);
    EXPECT_LE(result.replays, 5u);
    refined = refined || is_refined(result);
    if (frame >= kFirstFrames && result.replays > 0) ++replayed;
  }
  EXPECT_TRUE(refined) << "the scene is too small";
  EXPECT_LE(replayed, 2u);
}

TEST_F(Refinement, OfOnePointIsUselessButHarmless) {
  expect_right_and_rarely_replayed(two_groups(soup(226, 1500, 0, 0, 0), 227));
  Case with_far = two_groups(soup(226, 1500, 0, 0, 0), 227);
  add_soup(with_far, 228, 1, 1, 1, {1e4, 1e4, 1e4});
  expect_right_and_rarely_replayed(with_far);
}

TEST_F(Refinement, WhereAllTouchIsUselessButHarmless) {
  expect_right_and_rarely_replayed(two_groups(soup(229, 1500, 1e-3, 1, 0.01), 230));
}

// More crowded cells than there are bricks at first, most of them with little to gain. What becomes of the tests while
// bricks are missing says nothing of what refinement is worth.
TEST_F(Refinement, IsNotGivenUpWhileBricksAreMissing) {
  constexpr uint32_t kCrowd = 7500;
  constexpr double kCell = 1.0 / 128;
  Case c;
  add_mesh(c, {{0, 1, 2}}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}});  // spans the levels, together with the crowd
  for (int i = 0; i < 640; ++i) {
    const Vec3d cell{i % 16 * 8 + 3.5, i / 16 % 8 * 16 + 3.5, i / 128 * 24 + 3.5};
    add_soup(c, 240 + static_cast<uint32_t>(i), 64, 1e-4, 1e-5, {cell[0] * kCell, cell[1] * kCell, cell[2] * kCell});
  }
  add_soup(c, 236, kCrowd, 0.4 * kCell, 2e-5, {127.5 * kCell, 127.5 * kCell, 127.5 * kCell});
  add_soup(c, 237, 2, 0.1 * kCell, 1e-4, {126.5 * kCell, 127.5 * kCell, 127.5 * kCell});
  Scene scene(c, candidates(Scalar::kF64));
  const FrameResult first = scene.play(c), second = scene.play(c);
  EXPECT_TRUE(is_refined(first));
  EXPECT_TRUE(same_contacts(first, second));
  EXPECT_LT(first.counts.tests, uint64_t{kCrowd} * (kCrowd - 1) / 2 / 4);
  EXPECT_LT(second.counts.tests, uint64_t{kCrowd} * (kCrowd - 1) / 2 / 4);
}

// Frame by frame as a fresh detector, which has nothing left from the frames before.
void expect_fresh_each_frame(const std::vector<Case>& frames) {
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kFast, Scalar::kF32);
  Scene kept(frames[0], spec);
  for (int frame = 0; frame < 24; ++frame) {
    SCOPED_TRACE(frame);
    // Now one after the other, then each for a while.
    const Case& c = frames[static_cast<size_t>(frame < 8 ? frame : frame / 4) % frames.size()];
    const FrameResult result = kept.play(c);
    EXPECT_TRUE(same_contacts(Scene(c, spec).play(c), result));
    EXPECT_LE(result.replays, 5u);
  }
}

// One vertex flies far away and comes back: what was spread over all cells is a cluster in one of them for a frame.
TEST_F(Refinement, OfAClusterThatComesAndGoes) {
  const Case near = rounded(soup(231, kCluster, 1, 0.05, 0.005), Scalar::kF32);
  Case away = near, far_away = near, moving = near;
  away.start[0][7] = away.end[0][7] = {300, 200, 100};
  far_away.start[0][7] = far_away.end[0][7] = {3e6, 2e6, 1e6};
  moving.end[0][7] = {-3e3, 200, 100};
  expect_fresh_each_frame({near, away, near, far_away, moving});
}

// Half of the triangles shrink to a tiny cluster and are spread again.
TEST_F(Refinement, OfACrowdThatGathersAndParts) {
  const Case apart = rounded(soup(232, kCluster, 100, 2, 0.2), Scalar::kF32);
  Case together = apart;
  for (Positions* positions : {&together.start[0], &together.end[0]})
    for (size_t v = 0; v < 2 * positions->size() / 3; ++v)
      for (double& x : (*positions)[v]) x = 10 + x / 1000;
  expect_fresh_each_frame({apart, rounded(together, Scalar::kF32)});
}

}  // namespace
}  // namespace collided::test
