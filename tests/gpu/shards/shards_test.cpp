// A scene in any number of parts answers with the bytes of the scene on one device.

#include <cstdlib>

#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/shards/one_and_shards.hpp"
#include "tests/gpu/scene/living_scene.hpp"
#include "tests/gpu/step/random_stream.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

/// Streams of a test: COLLIDED_PART_STREAMS, or enough to see each kind of frame many times.
uint32_t stream_count() {
  const char* wanted = std::getenv("COLLIDED_PART_STREAMS");
  return wanted != nullptr ? static_cast<uint32_t>(std::atoi(wanted)) : 20;
}

using Parts = OnBackend<>;

TEST_F(Parts, GiveTheBytesOfOneScene) {
  uint64_t refused = 0, contacts = 0;
  const uint32_t streams = stream_count();
  for (uint32_t seed = 0; seed < streams; ++seed) {
    RandomStream stream(seed);
    OneAndParts scene(stream.spec());
    scene.detect(stream.first());
    for (int frame = 0; frame < 12; ++frame) {
      SCOPED_TRACE("stream " + std::to_string(seed) + " frame " + std::to_string(frame));
      const FrameInput input = stream.next();
      if (stream.random(4) == 0) give_up(*scene.in_parts[stream.random(4)], input, static_cast<int>(stream.random(12)));
      refused += !scene.detect(input);
      ASSERT_FALSE(HasFailure());
    }
    contacts += scene.contacts;
  }
  EXPECT_GT(refused, streams / 8);
  EXPECT_GT(contacts, 100u * streams);
}

TEST_F(Parts, FollowEdits) {
  for (const Mode mode : {Mode::kCcd, Mode::kDcd}) {
    LivingScene scene(mode, Scalar::kF32, 11);
    OneAndParts detectors(scene.spec(), {2, 3});
    detectors.detect(scene.first_frame().input());
    for (int i = 0; i < 24; ++i) {
      SCOPED_TRACE(i);
      const OwnedFrame frame = i % 2 == 1 ? scene.next_edit() : scene.next_frame();
      ASSERT_TRUE(detectors.detect(frame.input()));
      scene.applied(frame);
      ASSERT_FALSE(HasFailure());
    }
    EXPECT_EQ(detectors.one->topology().triangles, detectors.in_parts[1]->topology().triangles);
    EXPECT_EQ(detectors.in_parts[1]->spec().part_devices.size(), 3u);
    EXPECT_EQ(detectors.one->spec().meshes.size(), detectors.in_parts[1]->spec().meshes.size());
  }
}

class PartsOfScenes : public OnBackend<::testing::TestWithParam<std::string>> {};

TEST_P(PartsOfScenes, GiveTheBytesOfOneScene) {
  const auto scene = scenes::make_scene(GetParam(), GetParam() == "one_cell" ? 0.2 : 0.4);
  for (const Mode mode : {Mode::kCcd, Mode::kDcd}) {
    const double thickness = mode == Mode::kDcd ? dcd_thickness(GetParam()) / 10 : 0;
    const Case first = case_of(*scene, mode == Mode::kCcd ? 0.8 - 1.0 / 60 : 0.8, 0.8);
    OneAndParts detectors(spec_for(first, settings(mode, Accuracy::kCertified, Scalar::kF32, thickness)), {3});
    detectors.detect(Frame(first, mode, Scalar::kF32).input());
    const Case next = case_of(*scene, mode == Mode::kCcd ? 0.8 : 0.82, 0.82);
    detectors.detect(Frame(next, mode, Scalar::kF32, false).input());
  }
}
INSTANTIATE_TEST_SUITE_P(Procedural, PartsOfScenes, ::testing::ValuesIn(scene_names()),
                         [](const auto& info) { return info.param; });

/// Moving and static meshes, random and exactly touching features, loose ones, all in one place, and a sheet whose
/// triangles go through their neighbours.
std::vector<Case> hard_cases() {
  Case mixed = soup(130, 300, 6, 1, 0.5), in_one_place = soup(70, 400, 0.01, 0.5, 0.3);
  const Case wall = soup(131, 80, 6, 1, 0), integers = lattice(132, 60, 8);
  add_mesh(mixed, wall.meshes[0].triangles, wall.start[0], {}, true);
  add_mesh(mixed, integers.meshes[0].triangles, integers.start[0], integers.end[0]);
  return {mixed, loosened(mixed), in_one_place, far_apart(), crumpled(133, 12, 1.2)};
}

class PartsAtLevels : public OnBackend<::testing::TestWithParam<Accuracy>> {
 protected:
  static void expect_same(SceneSpec spec) {
    spec.fields = kEveryField.without(ContactField::kFeatures);  // parts tell none
    for (const Case& c : hard_cases()) {
      SCOPED_TRACE(c.name);
      OneAndParts detectors(spec_for(c, spec), {2, 5});
      detectors.detect(Frame(c, spec.mode, spec.scalar).input());
    }
  }
};

TEST_P(PartsAtLevels, Continuous) {
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
    for (const Report report : {Report::kAll, Report::kEarliestOnly, Report::kAnyHit}) {
      if (report == Report::kEarliestOnly && GetParam() < Accuracy::kGuarded) continue;
      if (report == Report::kAnyHit && GetParam() < Accuracy::kFast) continue;
      SceneSpec spec = settings(Mode::kCcd, GetParam(), scalar);
      spec.report = report;
      expect_same(spec);
    }
}
TEST_P(PartsAtLevels, Discrete) {
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
    SceneSpec spec = settings(Mode::kDcd, GetParam(), scalar, 0x1p-5);
    spec.kinds.triangle_triangle = true;
    expect_same(spec);
  }
}
INSTANTIATE_TEST_SUITE_P(Levels, PartsAtLevels,
                         ::testing::Values(Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded,
                                           Accuracy::kCertified, Accuracy::kExact),
                         [](const auto& info) { return level_name(info.param); });

class PartsByEngine : public OnBackend<::testing::TestWithParam<Engine>> {};

TEST_P(PartsByEngine, GiveTheBytesOfOneScene) {
  for (const char* name : {"cloth_ball", "multiscale_knots"}) {
    const auto scene = scenes::make_scene(name, 0.4);
    const Case c = case_of(*scene, 0.8 - 1.0 / 60, 0.8);
    SceneSpec spec = settings(Mode::kCcd, Accuracy::kGuarded, Scalar::kF32);
    spec.engine = GetParam();
    OneAndParts detectors(spec_for(c, spec), {2, 3});
    for (int frame = 0; frame < 2; ++frame) detectors.detect(Frame(c, Mode::kCcd, Scalar::kF32, frame == 0).input());
  }
}
INSTANTIATE_TEST_SUITE_P(Engines, PartsByEngine,
                         ::testing::Values(Engine::kOctree, Engine::kTopDown, Engine::kBottomUp, Engine::kUniformGrid,
                                           Engine::kTwoLevelGrid, Engine::kLbvh, Engine::kVss, Engine::kAllPairs));

constexpr uint32_t kClusters = 8, kTrianglesOfCluster = 3500;
constexpr uint64_t kPairsInClusters = uint64_t{kClusters} * kTrianglesOfCluster * (kTrianglesOfCluster - 1) / 2;

/// Far apart, each within a cell of the octree's dense levels.
Case clusters() {
  constexpr double kPlaces[] = {0, 3000, 7000, 10000};
  Case all;
  for (uint32_t k = 0; k < kClusters; ++k) {
    const Vec3d centre{kPlaces[k % 4], kPlaces[k / 4 * 3], kPlaces[k % 3]};
    const Case cluster = soup(300 + k, kTrianglesOfCluster, 1, 0.05, 0.005, centre);
    add_mesh(all, cluster.meshes[0].triangles, cluster.start[0], cluster.end[0]);
  }
  return all;
}

struct OneAndInParts {
  FrameResult one, in_parts;
};

/// Candidates of the octree in a scene's first frame.
OneAndInParts by_octree(const Case& exact, Mode mode, size_t parts) {
  const Case c = rounded(exact, Scalar::kF32);
  SceneSpec spec = settings(mode, Accuracy::kCandidates, Scalar::kF32);
  spec.engine = Engine::kOctree;
  OneAndParts detectors(spec_for(c, spec), {parts});
  const Frame frame(c, mode, Scalar::kF32);
  OneAndInParts found{detectors.one->detect(frame.input()), detectors.in_parts[0]->detect(frame.input())};
  expect_same_frame(found.one, found.in_parts, Report::kAll);
  return found;
}

// Whether crowded cells are refined goes by the triangles that a part has, not by the scene's.
TEST_F(Parts, RefineCrowdedCells) {
  const auto [one, in_parts] = by_octree(clusters(), Mode::kCcd, 4);
  EXPECT_LT(one.counts.tests, kPairsInClusters / 10);
  EXPECT_LT(in_parts.counts.tests, kPairsInClusters / 10);
}

// Levels that pay for few triangles only would be made where a part counted on all of the scene's.
TEST_F(Parts, HaveTheLevelsThatTheirTrianglesNeed) {
  const auto [one, in_parts] = by_octree(soup(310, 40000, 1, 0.05, 0), Mode::kDcd, 8);
  EXPECT_LT(in_parts.counts.cells, 4 * one.counts.cells);
  EXPECT_LT(in_parts.counts.registrations, 1.1 * one.counts.registrations);
}

// Fewer pairs than parts, and none at all.
TEST_F(Parts, MayHaveNothingToDo) {
  Case two, one;
  const Positions at = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  add_mesh(two, {{0, 1, 2}}, at, at);
  one = two;
  add_mesh(two, {{0, 1, 2}}, {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}});
  for (const Case& c : {one, two})
    for (const Engine engine : {Engine::kAuto, Engine::kOctree, Engine::kLbvh}) {
      SceneSpec spec = settings(Mode::kCcd, Accuracy::kExact);
      spec.engine = engine;
      OneAndParts detectors(spec_for(c, spec), {1, 2, 5, 17});
      for (int frame = 0; frame < 2; ++frame) EXPECT_TRUE(detectors.detect(Frame(c, Mode::kCcd, Scalar::kF64).input()));
      EXPECT_EQ(detectors.contacts > 0, c.meshes.size() == 2);
    }
}

// Shares follow the times that were measured, whatever these are here.
TEST_F(Parts, GiveTheSameBytesWhateverTheirShares) {
  const auto scene = scenes::make_scene("cloth_ball", 0.5);
  const auto at = [&](int i) { return case_of(*scene, 0.5 + 0.01 * i, 0.51 + 0.01 * i); };
  OneAndParts detectors(spec_for(at(0), settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32)), {4});
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(detectors.detect(Frame(at(i), Mode::kCcd, Scalar::kF32, i == 0).input()));
    ASSERT_FALSE(HasFailure());
  }
}

}  // namespace
}  // namespace collided::test
