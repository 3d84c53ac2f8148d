// Frames that advance go where the serial reference of tests/gpu/narrow goes, whose steps integer arithmetic judges, to
// the byte: in each mode, format and order of work.

#include <cstring>

#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/scene/step_cases.hpp"
#include "tests/gpu/shards/one_and_shards.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

FractionOf fraction_of(AdvanceMode mode) {
  return mode == AdvanceMode::kPerVertex ? FractionOf::kVertex
         : mode == AdvanceMode::kPerMesh ? FractionOf::kMesh
                                         : FractionOf::kScene;
}

class AdvanceModes : public OnBackend<::testing::Test> {
 protected:
  /// Compares some steps of a scene with the reference's.
  template <class Real>
  static void play(const StepScene& scene, double m, AdvanceMode mode, uint64_t seed, const SceneSpec& how) {
    constexpr Scalar kScalar = sizeof(Real) == 4 ? Scalar::kF32 : Scalar::kF64;
    Random random(seed);
    SerialSteps<Real> reference(scene, m, fraction_of(mode));
    std::vector<Vec3d> x = rounded_to<Real>(scene.positions);
    SceneSpec spec = how;
    spec.scalar = kScalar, spec.min_separation = m;
    const Case first = case_of(scene, x, x);
    const auto detector = Detector::create(spec_for(first, spec));
    detector->detect(Frame(first, Mode::kCcd, kScalar).input());
    double size = 0;
    for (const Vec3d& p : x) size = std::max({size, std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    for (int step = 0; step < 3; ++step) {
      const std::vector<Vec3d> p = any_target<Real>(scene, x, size, random);
      const StepResult expected = reference.advance(x, p);
      const Frame frame(case_of(scene, x, p), Mode::kDcd, kScalar, false);
      FrameInput input = frame.input();
      input.advance = true, input.advance_mode = mode;
      const FrameResult result = detector->detect(input);
      expect_same(scene, x, p, expected, mode, result);
      std::vector<std::byte> at(x.size() * position_bytes(kScalar));
      detector->read_positions({0, 1, x.size()}, at);
      ASSERT_EQ(at, pack(expected.y, kScalar)) << "step " << step;
      x = expected.y;
    }
  }

  static void expect_same(const StepScene& scene, const std::vector<Vec3d>& x, const std::vector<Vec3d>& p,
                          const StepResult& expected, AdvanceMode mode, const FrameResult& result) {
    double least = 1, gone = 0, all = 0;
    std::vector<uint32_t> ids;
    std::vector<double> fractions;
    for (uint32_t v = 0; v < x.size(); ++v) {
      if (x[v] == p[v]) continue;
      const Vec3d way = minus(p[v], x[v]);
      const double length = std::hypot(way[0], way[1], way[2]), a = expected.fractions[v];
      least = std::min(least, a), all += length, gone += a * length;
      const uint32_t id = mode == AdvanceMode::kPerVertex ? v : scene.mesh[v];
      if (mode == AdvanceMode::kAllOrOne || a == 1 || (!ids.empty() && ids.back() == id)) continue;
      ids.push_back(id), fractions.push_back(a);
    }
    EXPECT_EQ(result.advanced, least);
    EXPECT_NEAR(result.way, all > 0 ? gone / all : 1, 0x1p-20);
    EXPECT_EQ(result.shortened.ids, ids);
    EXPECT_EQ(result.shortened.fractions, fractions);
  }
};

TEST_F(AdvanceModes, GoWhereTheReferenceGoes) {
  for (uint64_t seed = 1; seed <= 24; ++seed)
    for (const AdvanceMode mode : kModes) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", mode " + std::to_string(static_cast<int>(mode)));
      SceneSpec spec = settings(Mode::kCcd, seed % 3 == 0 ? Accuracy::kExact : Accuracy::kCertified);
      spec.threads = seed % 2 == 0 ? 1 : 3;
      play<double>(placed_scene(seed, -12), seed % 5 == 0 ? 0 : 1e-3, mode, seed, spec);
      play<float>(placed_scene(seed, -5), seed % 5 == 0 ? 0 : 1e-3, mode, seed, spec);
    }
}

TEST_F(AdvanceModes, AreTheSameForEachEngineAndInShards) {
  for (uint64_t seed = 31; seed <= 36; ++seed)
    for (const AdvanceMode mode : kModes)
      for (const Engine engine : {Engine::kOctree, Engine::kUniformGrid, Engine::kLbvh, Engine::kAllPairs}) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", engine " + std::to_string(static_cast<int>(engine)));
        SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
        spec.engine = engine;
        play<double>(placed_scene(seed, -8), 1e-3, mode, seed, spec);
        play<double>(placed_scene(seed, -8), 1e-3, mode, seed, in_parts(spec, 1 + seed % 3));
      }
}

/// A column of triangles, each of which blocks the next one, so that islands stand in the end; and beside it a triangle
/// that goes half of its way.
TEST_F(AdvanceModes, EndWithIslandsWhereNothingElseHelps) {
  StepScene scene;
  for (uint32_t i = 0; i < 130; ++i) {
    const Turn turn({0, 0, 0.3 * i});
    std::vector<Vec3d> triangle{{-0.5, -0.5, i * 1e-3}, {0.5, -0.5, i * 1e-3}, {0, 0.6, i * 1e-3}};
    for (Vec3d& p : triangle) p = turn(p);
    scene.add(triangle, {{0, 1, 2}}, i == 0);
  }
  const std::vector<Vec3d> apart{{8, 0, 0}, {9, 0, 0}, {8, 1, 0}};
  scene.add(apart, {{0, 1, 2}}, true);
  scene.add({plus(apart[0], {0.1, 0.2, 0.1}), plus(apart[1], {0, 0.2, 0.1}), plus(apart[2], {0.1, 0, 0.1})},
            {{0, 1, 2}});
  std::vector<Vec3d> p = scene.positions;
  for (size_t v = 3; v < p.size() - 6; ++v) p[v][2] -= 0.5e-3;
  for (size_t v = p.size() - 3; v < p.size(); ++v) p[v][2] -= 0.2;
  const StepResult expected = SerialSteps<double>(scene, 1e-3, FractionOf::kMesh).advance(scene.positions, p);
  ASSERT_GT(expected.rounds, 96u) << "islands";
  EXPECT_NEAR(expected.fractions.back(), 0.5, 0.01);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.min_separation = 1e-3;
  const Case at_rest = case_of(scene, scene.positions, scene.positions), way = case_of(scene, scene.positions, p);
  for (const size_t shards : {0, 2}) {
    const SceneSpec all = spec_for(at_rest, shards > 0 ? in_parts(spec, shards) : spec);
    const auto detector = Detector::create(all);
    detector->detect(Frame(at_rest, Mode::kCcd, Scalar::kF64).input());
    const Frame frame(way, Mode::kDcd, Scalar::kF64, false);
    FrameInput input = frame.input();
    input.advance = true, input.advance_mode = AdvanceMode::kPerMesh;
    expect_same(scene, scene.positions, p, expected, AdvanceMode::kPerMesh, detector->detect(input));
    std::vector<std::byte> at(p.size() * position_bytes(Scalar::kF64));
    detector->read_positions({0, 1, p.size()}, at);
    EXPECT_EQ(at, pack(expected.y, Scalar::kF64));
  }
}

/// Once a GPU allocates no more memory, it runs all rounds in one launch after that of the step.
TEST_F(AdvanceModes, TellTheSameOverAndOver) {
  size_t with_rounds = 0;
  for (uint64_t seed = 41; seed <= 52; ++seed)
    for (const AdvanceMode mode : kModes) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", mode " + std::to_string(static_cast<int>(mode)));
      Random random(seed);
      const StepScene scene = placed_scene(seed, -8);
      const std::vector<Vec3d> p = any_target<double>(scene, scene.positions, 1, random);
      SceneSpec spec = settings(Mode::kCcd, seed % 3 == 0 ? Accuracy::kExact : Accuracy::kCertified);
      spec.min_separation = 1e-3;
      const Case at_rest = case_of(scene, scene.positions, scene.positions), way = case_of(scene, scene.positions, p);
      const auto detector = Detector::create(spec_for(at_rest, spec));
      detector->detect(Frame(at_rest, Mode::kCcd, Scalar::kF64).input());
      const Frame frame(way, Mode::kDcd, Scalar::kF64, false);
      FrameInput input = frame.input();
      input.advance = input.trial = true, input.advance_mode = mode;
      const FrameResult first = detector->detect(input);
      for (int i = 0; i < 5; ++i) {
        const FrameResult again = detector->detect(input);
        EXPECT_EQ(again.advanced, first.advanced);
        EXPECT_EQ(again.way, first.way);
        EXPECT_EQ(again.shortened.ids, first.shortened.ids);
        EXPECT_EQ(again.shortened.fractions, first.shortened.fractions);
        if (i < 4) continue;
        with_rounds += *again.advanced < 1;
        EXPECT_EQ(again.allocations, 0u);
        if (kBackend == Backend::kCuda) {
          EXPECT_EQ(again.graph_launches, *again.advanced < 1 ? 2u : 1u);
        }
      }
    }
  EXPECT_GT(with_rounds, 12u);
}

/// Floors follow from the scene's size and way in the frame, not from what they were in the one before.
TEST_F(AdvanceModes, AreTheSameWhateverSizeTheSceneHadBefore) {
  constexpr AdvanceMode kMode = AdvanceMode::kPerVertex;
  Random random(7);
  const StepScene scene = placed_scene(3, -6);
  const std::vector<Vec3d> p = any_target<double>(scene, scene.positions, 1, random);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  for (const double m : {0.0, 1e-3}) {
    spec.min_separation = m;
    const auto scaled = [&](const std::vector<Vec3d>& positions, double scale) {
      std::vector<Vec3d> out;
      for (const Vec3d& v : positions) out.push_back(times(scale, v));
      return out;
    };
    const auto played = [&](Detector& detector, double scale) {
      const Case way = case_of(scene, scaled(scene.positions, scale), scaled(p, scale));
      const Frame frame(way, Mode::kCcd, Scalar::kF64);
      FrameInput input = frame.input();
      input.advance = true, input.advance_mode = kMode;
      return detector.detect(input);
    };
    const SceneSpec whole = spec_for(case_of(scene, scene.positions, p), spec);
    const auto detector = Detector::create(whole);
    for (const double scale : {1.0, 0x1p20, 1.0, 1.0, 0x1p-20, 0x1p30, 0x1p30, 1.0}) {
      SCOPED_TRACE("scale " + std::to_string(scale) + ", m " + std::to_string(m));
      const FrameResult expected = played(*Detector::create(whole), scale), result = played(*detector, scale);
      EXPECT_EQ(result.advanced, expected.advanced);
      EXPECT_EQ(result.way, expected.way);
      EXPECT_EQ(result.shortened.ids, expected.shortened.ids);
      EXPECT_EQ(result.shortened.fractions, expected.shortened.fractions);
      EXPECT_EQ(digest(result), digest(expected));
    }
  }
}

/// Also where the frame's lists turn out too short.
TEST_F(AdvanceModes, TellTheContactsOfTheWholeWay) {
  StepScene scene;
  add(scene, sheet(60, 1, {0, 0, 0}));
  add(scene, sheet(60, 1, {0.003, 0.004, 0.02}));
  std::vector<Vec3d> p = scene.positions;
  for (size_t v = p.size() / 2; v < p.size(); ++v)
    p[v][2] -= 0.03 + 0.01 * std::sin(40 * p[v][0]) * std::cos(30 * p[v][1]);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.min_separation = 1e-3;
  const Frame frame(case_of(scene, scene.positions, p), Mode::kCcd, Scalar::kF64);
  const auto contacts_of = [&](bool advances) {
    FrameInput input = frame.input();
    input.advance = advances;
    if (advances) input.advance_mode = AdvanceMode::kPerVertex;
    const FrameResult result = Detector::create(spec_for(case_of(scene, scene.positions, p), spec))->detect(input);
    return std::pair(digest(result.vertex_triangle, 1), digest(result.edge_edge, 1));
  };
  for (int i = 0; i < 5; ++i) EXPECT_EQ(contacts_of(true), contacts_of(false));
}

TEST_F(AdvanceModes, NeedAFrameThatAdvances) {
  const StepScene scene = any_scene(0, 0.1);
  const Case c = case_of(scene, scene.positions, scene.positions);
  const auto detector = Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kCertified)));
  const Frame frame(c, Mode::kCcd, Scalar::kF64);
  FrameInput input = frame.input();
  input.advance_mode = AdvanceMode::kPerMesh;
  EXPECT_EQ("advance_mode", refused_field([&] { detector->detect(input); }));
}

}  // namespace
}  // namespace collided::test
