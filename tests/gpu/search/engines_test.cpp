// Every engine of the broad phase finds the same pairs, in the same order, and says that it was the one.

#include <algorithm>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

constexpr Engine kEngines[] = {Engine::kOctree,       Engine::kTopDown, Engine::kBottomUp, Engine::kUniformGrid,
                               Engine::kTwoLevelGrid, Engine::kLbvh,    Engine::kVss,      Engine::kAllPairs};

SceneSpec settings_of(Engine engine, Mode mode, double thickness = 0, Accuracy accuracy = Accuracy::kCandidates) {
  SceneSpec spec = settings(mode, accuracy, Scalar::kF32, thickness);
  spec.engine = engine;
  return spec;
}

void expect_same(const FrameResult& octree, const FrameResult& other, Engine engine) {
  EXPECT_EQ(other.broad_phase.engine, engine);
  EXPECT_TRUE(same_contacts(octree, other))
      << octree.vertex_triangle.size() << " + " << octree.edge_edge.size() << " against "
      << other.vertex_triangle.size() << " + " << other.edge_edge.size();
  EXPECT_TRUE(same_bytes(octree.triangle_triangle, other.triangle_triangle))
      << octree.triangle_triangle.size() << " against " << other.triangle_triangle.size();
  EXPECT_EQ(octree.counts.pairs, other.counts.pairs);
}

/// The octree's answer, which all others give too.
FrameResult expect_engines_agree(const Case& exact, Mode mode, double thickness) {
  const Case c = rounded(exact, Scalar::kF32);
  const FrameResult octree = run_case(c, settings_of(Engine::kOctree, mode, thickness));
  for (Engine engine : kEngines) {
    SCOPED_TRACE(c.name + " engine " + std::to_string(static_cast<int>(engine)));
    expect_same(octree, run_case(c, settings_of(engine, mode, thickness)), engine);
  }
  return octree;
}

void expect_engines_are_right(const Case& exact, Mode mode, double thickness) {
  const FrameResult octree = expect_engines_agree(exact, mode, thickness);
  const ExpectedPairs expected = brute_force(rounded(exact, Scalar::kF32), mode, Scalar::kF32, thickness);
  EXPECT_EQ("", compare(octree.vertex_triangle.elements, expected.vertex_triangle)) << "vertex-triangle";
  EXPECT_EQ("", compare(octree.edge_edge.elements, expected.edge_edge)) << "edge-edge";
}

class EnginesOnScene : public OnBackend<::testing::TestWithParam<std::string>> {
 protected:
  static constexpr double kScale = 0.4;
};

TEST_P(EnginesOnScene, Continuous) {
  const auto scene = scenes::make_scene(GetParam(), kScale);
  for (double t : {0.2, 0.8}) expect_engines_are_right(case_of(*scene, t - 1.0 / 60, t), Mode::kCcd, 0);
}

TEST_P(EnginesOnScene, Discrete) {
  const auto scene = scenes::make_scene(GetParam(), kScale);
  expect_engines_are_right(case_of(*scene, 0.8, 0.8), Mode::kDcd, dcd_thickness(GetParam()));
}

// Levels, cells and lists come from the frames before, and static meshes keep their boxes.
TEST_P(EnginesOnScene, FrameByFrame) {
  const auto scene = scenes::make_scene(GetParam(), kScale);
  std::vector<std::unique_ptr<Detector>> detectors;
  for (Engine engine : kEngines)
    detectors.push_back(Detector::create(spec_for(case_of(*scene, 0, 0), settings_of(engine, Mode::kCcd))));
  for (int frame = 0; frame < 5; ++frame) {
    const Frame input(case_of(*scene, 0.15 * frame, 0.15 * frame + 1.0 / 60), Mode::kCcd, Scalar::kF32, frame == 0);
    const FrameResult octree = detectors[0]->detect(input.input());
    for (size_t i = 1; i < detectors.size(); ++i) expect_same(octree, detectors[i]->detect(input.input()), kEngines[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(Procedural, EnginesOnScene, ::testing::ValuesIn(scene_names()),
                         [](const auto& info) { return info.param; });

/// `count` triangles in the same place, far from each other in number.
Case same_boxes(uint32_t count) {
  Case c = soup(140, 200, 1, 0.1, 0.02);
  for (size_t v = 3; v < 3 * size_t{count}; ++v) {
    c.start[0][v] = c.start[0][v % 3];
    c.end[0][v] = c.end[0][v % 3];
  }
  c.name = "SameBoxes";
  return c;
}

/// Boxes on the corners of a lattice: equal codes in many places, faces that just touch.
Case equal_codes() {
  Case c = soup(141, 512, 1, 0.1, 0);
  for (size_t t = 0; t < 512; ++t)
    for (size_t k = 0; k < 3; ++k) {
      Vec3d p{static_cast<double>(t % 4), static_cast<double>(t / 4 % 4), static_cast<double>(t / 16 % 4)};
      p[k] += 1;
      c.start[0][3 * t + k] = c.end[0][3 * t + k] = p;
    }
  c.name = "EqualCodes";
  return c;
}

std::vector<Case> families() {
  std::vector<Case> all = adversarial_cases();
  all.push_back(same_boxes(150));
  all.push_back(equal_codes());
  return all;
}

class EnginesOnFamily : public OnBackend<::testing::TestWithParam<Case>> {};

TEST_P(EnginesOnFamily, Continuous) { expect_engines_are_right(GetParam(), Mode::kCcd, 0); }
TEST_P(EnginesOnFamily, Discrete) { expect_engines_are_right(GetParam(), Mode::kDcd, 0.01); }

// All reports and kinds go through the same search.
TEST_P(EnginesOnFamily, ContactsOfEveryKind) {
  const Case c = rounded(GetParam(), Scalar::kF32);
  for (Mode mode : {Mode::kDcd, Mode::kCcd})
    for (Accuracy accuracy : {Accuracy::kCandidates, Accuracy::kGuarded}) {
      SceneSpec spec = settings_of(Engine::kOctree, mode, 0, accuracy);
      spec.kinds.triangle_triangle = mode == Mode::kDcd || accuracy == Accuracy::kCandidates;
      const FrameResult octree = run_case(c, spec);
      for (Engine engine : kEngines) {
        SCOPED_TRACE(std::to_string(static_cast<int>(engine)));
        spec.engine = engine;
        expect_same(octree, run_case(c, spec), engine);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Adversarial, EnginesOnFamily, ::testing::ValuesIn(families()),
                         [](const auto& info) { return info.param.name; });

class EnginesOnFrames : public OnBackend<::testing::TestWithParam<RealFrames>> {};

TEST_P(EnginesOnFrames, Agree) {
  if (!are_here(GetParam())) GTEST_SKIP() << kNoDataFolder;
  const Case c = load(GetParam());
  expect_engines_agree(c, Mode::kCcd, 0);
  if (GetParam().name != kBallFrames.name) expect_engines_agree(c, Mode::kDcd, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Real, EnginesOnFrames, ::testing::Values(kDrapeFrames, kFunnelFrames, kBallFrames),
                         [](const auto& info) { return std::string(info.param.name); });

class EachEngine : public OnBackend<::testing::TestWithParam<Engine>> {};

TEST_P(EachEngine, AnyHitIsTheOctrees) {
  for (double side : {1.0, 60.0}) {  // crowded; too sparse for contacts
    const Case c = rounded(soup(142, 200, side, 0.1, 0.02), Scalar::kF32);
    SceneSpec spec = settings_of(Engine::kOctree, Mode::kCcd, 0, Accuracy::kGuarded);
    spec.report = Report::kAnyHit;
    const bool expected = run_case(c, spec).any_contact;
    spec.engine = GetParam();
    EXPECT_EQ(run_case(c, spec).any_contact, expected);
  }
}

TEST_P(EachEngine, CountsDoNotDependOnTheRun) {
  const Case c = soup(143, 3000, 1, 0.06, 0.02);
  const SceneSpec spec = settings_of(GetParam(), Mode::kCcd);
  const FrameCounts one = run_case(c, spec).counts, other = run_case(c, spec).counts;
  EXPECT_GT(one.tests, 0u);
  EXPECT_EQ(one.tests, other.tests);
  EXPECT_EQ(one.leaves, other.leaves);
  EXPECT_EQ(one.registrations, other.registrations);
}

TEST_P(EachEngine, AllocatesNothingOnceWarm) {
  const Case c = soup(144, 500, 1, 0.1, 0.02);
  const auto detector = Detector::create(spec_for(c, settings_of(GetParam(), Mode::kCcd)));
  const Frame frame(c, Mode::kCcd, Scalar::kF32);
  for (int warm_up = 0; warm_up < 3; ++warm_up) detector->detect(frame.input());
  const FrameResult r = detector->detect(frame.input());
  EXPECT_EQ(r.allocations, 0u);
  EXPECT_EQ(r.replays, 0u);
}

INSTANTIATE_TEST_SUITE_P(All, EachEngine, ::testing::ValuesIn(kEngines),
                         [](const auto& info) { return "Engine" + std::to_string(static_cast<int>(info.param)); });

using Engines = OnBackend<>;

TEST_F(Engines, HoldOnlyTheirOwnBuffersAndRunOnlyTheirOwnStages) {
  const Case c = soup(145, 300, 1, 0.1, 0.02);
  const Frame frame(c, Mode::kCcd, Scalar::kF32);
  for (Engine engine : kEngines) {
    const auto detector = Detector::create(spec_for(c, settings_of(engine, Mode::kCcd)));
    const FrameResult r = detector->detect(frame.input());
    const std::vector<MemoryPart> memory = detector->memory();
    const auto has_part = [&](const char* name) {
      return std::any_of(memory.begin(), memory.end(), [&](const MemoryPart& m) { return m.part == name; });
    };
    const auto has_stage = [&](const char* name) {
      return std::any_of(r.stages.begin(), r.stages.end(), [&](const StageTime& s) { return s.stage == name; });
    };
    const bool is_lbvh = engine == Engine::kLbvh, is_all_pairs = engine == Engine::kAllPairs;
    const bool is_octree = !is_lbvh && !is_all_pairs;
    for (const char* part : {"octree", "registrations"}) EXPECT_EQ(has_part(part), is_octree) << part;
    EXPECT_EQ(has_part("bvh"), is_lbvh);
    EXPECT_EQ(has_part("all_pairs"), is_all_pairs);
    for (const char* stage : {"count", "bottom_up", "top_down", "registration"})
      EXPECT_EQ(has_stage(stage), is_octree) << stage;
    for (const char* stage : {"sort", "hierarchy"}) EXPECT_EQ(has_stage(stage), is_lbvh) << stage;
    for (const char* stage : {"boxes", "levels", "pairs"}) EXPECT_TRUE(has_stage(stage)) << stage;
  }
}

TEST_F(Engines, AutoStartsWithTheOctreeAndInSmallScenesWithAllPairs) {
  for (const uint32_t triangles : {300u, 4200u}) {
    const FrameResult result = run_case(soup(146, triangles, 1, 0.02, 0.02), settings_of(Engine::kAuto, Mode::kCcd));
    EXPECT_EQ(result.broad_phase.engine, triangles == 300 ? Engine::kAllPairs : Engine::kOctree);
    EXPECT_EQ(result.broad_phase.reason, EngineReason::kFirst);
  }
}

TEST_F(Engines, AllPairsTestsEachPairOnce) {
  for (const uint32_t n : {2u, 31u, 32u, 33u, 300u, 4100u}) {
    const FrameCounts counts = run_case(soup(147, n, 1, 0.02, 0.02), settings_of(Engine::kAllPairs, Mode::kCcd)).counts;
    EXPECT_EQ(counts.tests, uint64_t{n} * (n - 1) / 2);
    EXPECT_EQ(counts.cells, 1u);
    EXPECT_EQ(counts.registrations, 0u);
  }
}

// Knots of very different sizes, one frame after the other: it leaves them to the hierarchy, and the answer is the
// octree's.
TEST_F(Engines, AutoGivesTheOctreesAnswer) {
  const Case c = rounded(case_of(*scenes::make_scene("multiscale_knots_4"), 0.8 - 1.0 / 60, 0.8), Scalar::kF32);
  const auto detector = Detector::create(spec_for(c, settings_of(Engine::kAuto, Mode::kCcd)));
  const Frame frame(c, Mode::kCcd, Scalar::kF32);
  const FrameResult first = detector->detect(frame.input()), second = detector->detect(frame.input());
  EXPECT_EQ(first.broad_phase.engine, Engine::kOctree);
  EXPECT_EQ(second.broad_phase.engine, Engine::kLbvh);
  EXPECT_EQ(second.broad_phase.reason, EngineReason::kCounters);
  expect_same(first, second, second.broad_phase.engine);
}

// Compares engines on its way, and gives their memory back.
class AutoComparesEngines : public OnBackend<::testing::Test> {
 protected:
  static constexpr int kFrames = 40;

  bool holds(const std::string& part) const {
    const auto parts = detector_->memory();
    return std::any_of(parts.begin(), parts.end(),
                       [&](const MemoryPart& held) { return held.part == part && held.bytes > 0; });
  }
  void begin(const SceneSpec& spec) { detector_ = Detector::create(spec_for(case_, spec)); }
  FrameResult next_frame() { return detector_->detect(Frame(case_, Mode::kCcd, Scalar::kF32).input()); }

  const Case case_ = rounded(case_of(*scenes::make_scene("cloth_ball", 0.4), 0.8 - 1.0 / 60, 0.8), Scalar::kF32);
  std::unique_ptr<Detector> detector_;
};

// Times decide, and a busy machine distorts them: a later comparison may still run after kFrames frames, and one whose
// frames take too long is given up for good, so that a detector may know nothing.
TEST_F(AutoComparesEngines, WithTheSameAnswers) {
  constexpr int kDetectors = 8;
  FrameResult last;
  int trials = 0;
  for (int detector = 0; detector < kDetectors && last.broad_phase.reason != EngineReason::kFaster; ++detector) {
    begin(settings_of(Engine::kAuto, Mode::kCcd));
    const FrameResult first = next_frame();
    last = first;
    const auto is_compared = [&] { return last.broad_phase.reason == EngineReason::kTrial; };
    for (int frame = 1; frame < kFrames || (is_compared() && frame < 2 * kFrames); ++frame) {
      last = next_frame();
      EXPECT_TRUE(same_contacts(first, last)) << frame;
      trials += is_compared();
    }
  }
  EXPECT_GE(trials, 1);
  ASSERT_EQ(last.broad_phase.reason, EngineReason::kFaster);
  EXPECT_GT(last.broad_phase.octree_milliseconds, 0);
  EXPECT_GT(last.broad_phase.lbvh_milliseconds, 0);
  const bool is_octree = last.broad_phase.engine == Engine::kOctree;
  EXPECT_EQ(holds("registrations"), is_octree);
  EXPECT_EQ(holds("bvh"), !is_octree);
}

// A budget of what the octree needs.
TEST_F(AutoComparesEngines, WithoutRefusingAFrameForWantOfRoom) {
  SceneSpec spec = settings_of(Engine::kOctree, Mode::kCcd);
  begin(spec);
  for (int frame = 0; frame < 3; ++frame) next_frame();
  spec.memory_budget = 0;
  for (const MemoryPart& part : detector_->memory())
    if (part.part != "answers" && part.part != "pinned") spec.memory_budget += part.bytes;  // those are the host's
  spec.engine = Engine::kAuto;
  begin(spec);
  for (int frame = 0; frame < kFrames; ++frame) {
    const EngineFacts facts = next_frame().broad_phase;
    EXPECT_EQ(facts.engine, Engine::kOctree);
    EXPECT_EQ(facts.reason, EngineReason::kFirst);
  }
}

// Such frames take as long as they take until they have one, whatever the engine.
TEST_F(AutoComparesEngines, NotByFramesThatEndWithAnyHit) {
  SceneSpec spec = settings_of(Engine::kAuto, Mode::kCcd, 0, Accuracy::kCertified);
  spec.report = Report::kAnyHit;
  begin(spec);
  for (int frame = 0; frame < kFrames; ++frame) EXPECT_EQ(next_frame().broad_phase.reason, EngineReason::kFirst);
}

}  // namespace
}  // namespace collided::test
