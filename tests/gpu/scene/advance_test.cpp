// How far a scene goes towards the positions that it is given: never into contact, and nearly as far as it can.

#include <algorithm>
#include <cmath>

#include "gpu/positions/blend.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/sim/simulations.hpp"

namespace collided::test {
namespace {

constexpr Scalar kFormats[] = {Scalar::kF32, Scalar::kF64};

TEST(Blend, EndsWhereItIsToldTo) {
  const float x = 0.1f, p = 1e8f;
  EXPECT_EQ(x, blend(x, p, 0.0));
  EXPECT_EQ(p, blend(x, p, 1.0));
  EXPECT_EQ(-1e300, blend(1.0, -1e300, 1.0));
  EXPECT_EQ(3.5, blend(3.0, 4.0, 0.5));
}

TEST(Blend, IsRoundedOnceToTheFormat) {
  const float x = 1, p = 1 + 0x1p-20f;
  EXPECT_EQ(static_cast<float>(1.0 + 0.3 * 0x1p-20), blend(x, p, 0.3));
}

SceneSpec ccd(const Case& c, Scalar scalar, double thickness = 0, double min_separation = 0) {
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, scalar, thickness);
  spec.min_separation = min_separation;
  return spec_for(c, spec);
}

/// A triangle at height `z` over a larger one.
Case falling(double from, double to) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, {{-1, -1, from}, {1, -1, from}, {0, 1, from}}, {{-1, -1, to}, {1, -1, to}, {0, 1, to}});
  add_mesh(c, {{0, 1, 2}}, {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}});
  return c;
}

class Stepping : public OnBackend<::testing::Test> {
 protected:
  /// The case's start is the scene's first frame.
  static std::unique_ptr<Detector> scene_at_start(const Case& c, const SceneSpec& spec) {
    Case first = c;
    first.end = first.start;
    auto scene = Detector::create(spec);
    scene->detect(Frame(first, Mode::kDcd, spec.scalar).input());
    return scene;
  }
  static FrameResult go(Detector& scene, const Case& c, Scalar scalar, const std::function<void(FrameInput&)>& set) {
    const Frame frame(c, Mode::kDcd, scalar);
    FrameInput input = frame.input();
    set(input);
    return scene.detect(input);
  }
};
const auto kAdvance = [](FrameInput& frame) { frame.advance = true; };

TEST_F(Stepping, GoesAllTheWayWhereItIsFree) {
  for (const Scalar scalar : kFormats) {
    const Case c = falling(1, 0.5);
    EXPECT_EQ(1, go(*scene_at_start(c, ccd(c, scalar)), c, scalar, kAdvance).advanced);
  }
}

TEST_F(Stepping, StopsBeforeContactOrTheSeparation) {
  for (const Scalar scalar : kFormats) {
    const Case c = falling(1, -1);
    const double to_contact = *go(*scene_at_start(c, ccd(c, scalar)), c, scalar, kAdvance).advanced;
    EXPECT_LT(to_contact, 0.5);
    EXPECT_GT(to_contact, 0.49);
    const double kept = *go(*scene_at_start(c, ccd(c, scalar, 0, 0.5)), c, scalar, kAdvance).advanced;
    EXPECT_LT(kept, 0.25);
    EXPECT_GT(kept, 0.245);
  }
}

/// A loose edge or point at height `z` over one that lies across it, or below it.
Case falling_loose(bool is_edge, bool onto_edge, double from, double to) {
  Case c;
  add_mesh(c, {}, {{-1, 0, from}, {1, 0, from}, {0, 0, from}}, {{-1, 0, to}, {1, 0, to}, {0, 0, to}});
  add_mesh(c, {}, {{0, -1, 0}, {0, 1, 0}, {0, 0, 0}});
  if (is_edge) c.meshes[0].edges = {{0, 1}};
  if (!is_edge) c.meshes[0].points = {2};
  if (onto_edge) c.meshes[1].edges = {{0, 1}};
  if (!onto_edge) c.meshes[1].points = {2};
  return c;
}

TEST_F(Stepping, StopsBeforeLooseElements) {
  for (const Scalar scalar : kFormats)
    for (const bool is_edge : {false, true})
      for (const bool onto_edge : {false, true}) {
        const Case c = falling_loose(is_edge, onto_edge, 1, -1);
        const double to_contact = *go(*scene_at_start(c, ccd(c, scalar)), c, scalar, kAdvance).advanced;
        EXPECT_LT(to_contact, 0.5);
        EXPECT_GT(to_contact, 0.49);
        const double kept = *go(*scene_at_start(c, ccd(c, scalar, 0, 0.5)), c, scalar, kAdvance).advanced;
        EXPECT_LT(kept, 0.25);
        EXPECT_GT(kept, 0.245);
      }
}

TEST_F(Stepping, OtherFramesTellNoFraction) {
  const Case c = falling(1, -1);
  EXPECT_FALSE(go(*scene_at_start(c, ccd(c, Scalar::kF64)), c, Scalar::kF64, [](FrameInput&) {}).advanced);
}

// Frame after frame towards a place behind the obstacle: the gap shrinks until nothing moves, and is never lost; then
// a frame that leads away is free.
TEST_F(Stepping, WhatIsPressedForEverStaysApartAndIsFreeToPart) {
  for (const Scalar scalar : kFormats) {
    const Case c = falling(1, -1), away = falling(1, 2);
    const auto scene = scene_at_start(c, ccd(c, scalar));
    for (int i = 0; i < 40; ++i) go(*scene, c, scalar, kAdvance);
    EXPECT_EQ(1, go(*scene, away, scalar, kAdvance).advanced);
  }
}

// Within min_separation from the start: it may rest and part, but not come closer.
TEST_F(Stepping, WhatBeginsTooCloseMayPart) {
  for (const Scalar scalar : kFormats) {
    const Case away = falling(0.25, 1), rest = falling(0.25, 0.25), closer = falling(0.25, 0.125);
    EXPECT_EQ(1, go(*scene_at_start(away, ccd(away, scalar, 0.5, 0.5)), away, scalar, kAdvance).advanced);
    EXPECT_EQ(1, go(*scene_at_start(rest, ccd(rest, scalar, 0.5, 0.5)), rest, scalar, kAdvance).advanced);
    EXPECT_EQ(0, go(*scene_at_start(closer, ccd(closer, scalar, 0.5, 0.5)), closer, scalar, kAdvance).advanced);
  }
}

/// The contacts, the earliest time and the advance of a frame agree. What starts in contact may go on as long as it
/// comes no closer, and what keeps a separation may come a little closer on the way. `may_stick`: the frame may begin
/// as close to contact as the format resolves.
void expect_one_story(const FrameResult& result, Accuracy accuracy, double separation, bool may_stick) {
  bool is_free = true;
  double earliest = 1;
  for (const ContactSet* set : {&result.vertex_triangle, &result.edge_edge})
    for (size_t i = 0; i < set->size(); ++i) {
      if ((set->flags[i] & kFlagSeparating) != 0) continue;
      is_free = false;
      earliest = std::min(earliest, set->toi[i]);
    }
  EXPECT_EQ(earliest, result.earliest_toi);
  ASSERT_TRUE(result.advanced);
  EXPECT_GE(*result.advanced, 0);
  EXPECT_LE(*result.advanced, 1);
  if (is_free) {
    EXPECT_EQ(1, *result.advanced) << "nothing approaches";
  } else if (earliest > 0 && separation == 0 && (accuracy == Accuracy::kExact || earliest < 1)) {
    EXPECT_TRUE(*result.advanced < earliest || *result.advanced == 0) << *result.advanced << " of " << earliest;
    EXPECT_TRUE(*result.advanced > 0 || may_stick) << "free until " << earliest;
  }
}

/// A vertex in a triangle's plane, `gap` away from a slanted side, and the triangle that it belongs to.
Case in_a_plane(double gap, bool moves) {
  const std::array<double, 2> out{0.25 / std::sqrt(1.0625), -1 / std::sqrt(1.0625)};
  const std::array<double, 2> p{0.5 + gap * out[0], 0.125 + gap * out[1]};
  const auto at = [](double x, double y) { return Vec3d{x, y, x + y / 2}; };
  const auto from_p = [&](double along, double x, double y) {
    return at(p[0] + along * out[0] + x, p[1] + along * out[1] + y);
  };
  Case c;
  add_mesh(c, {{0, 1, 2}}, {at(0, 0), at(1, 0.25), at(0.25, 1)});
  Positions start{from_p(0, 0, 0), from_p(0.3, 0.1, 0.02), from_p(0.25, -0.1, -0.05)}, end = start;
  if (moves)
    for (Vec3d& x : end) x = {x[0] + 0.2, x[1] + 0.05, x[2] + 0.225};
  add_mesh(c, {{0, 1, 2}}, start, end);
  return c;
}

TEST_F(Stepping, ContactsAndAdvanceTellOneStory) {
  std::vector<Case> cases{falling(1, 0), falling(1, -1), falling(1, 1), falling(0, 1), falling(0, 0)};
  for (int exponent = -16; exponent <= -8; ++exponent)
    for (const bool moves : {false, true}) cases.push_back(in_a_plane(std::pow(10.0, exponent), moves));
  const size_t made = cases.size();
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    cases.push_back(soup(seed, 12 + 2 * seed, 1, 0.1, 0.05));
    cases.push_back(lattice(seed, 3 + seed / 3, 8));
  }
  for (const Accuracy accuracy : {Accuracy::kCertified, Accuracy::kExact})
    for (const Scalar scalar : kFormats)
      for (const double separation : {0.0, 0x1p-6})
        for (size_t i = 0; i < cases.size(); ++i) {
          const Case c = rounded(cases[i], scalar);
          SceneSpec spec = ccd(c, scalar, separation, separation);
          spec.accuracy = accuracy;
          SCOPED_TRACE(level_name(accuracy) + " case " + std::to_string(i) + (separation > 0 ? " separated" : ""));
          expect_one_story(go(*scene_at_start(c, spec), c, scalar, kAdvance), accuracy, separation, i < made);
        }
}

// Exact times may be 1, and the end of the way is then in contact.
TEST_F(Stepping, StopsBeforeAContactAtTheVeryEnd) {
  for (const Accuracy accuracy : {Accuracy::kCertified, Accuracy::kExact}) {
    const Case c = falling(1, 0);
    SceneSpec spec = ccd(c, Scalar::kF64);
    spec.accuracy = accuracy;
    const double advanced = *go(*scene_at_start(c, spec), c, Scalar::kF64, kAdvance).advanced;
    EXPECT_LT(advanced, 1);
    EXPECT_GT(advanced, 0.98);
  }
}

TEST_F(Stepping, GoesOnPastWhatIsNoContactByALittle) {
  for (const bool moves : {false, true})
    for (int exponent = -15; exponent <= -8; ++exponent) {
      const Case c = in_a_plane(std::pow(10.0, exponent), moves);
      SceneSpec spec = ccd(c, Scalar::kF64);
      spec.accuracy = Accuracy::kExact;
      const FrameResult result = go(*scene_at_start(c, spec), c, Scalar::kF64, kAdvance);
      EXPECT_EQ(0u, result.vertex_triangle.size() + result.edge_edge.size()) << "1e" << exponent;
      EXPECT_EQ(1, result.advanced) << "1e" << exponent;
    }
}

TEST_F(Stepping, TheSceneIsWhereTheFormulaPutsIt) {
  for (const Scalar scalar : kFormats) {
    const Case c = rounded(falling(1, -1), scalar);
    const auto scene = scene_at_start(c, ccd(c, scalar));
    const double a = *go(*scene, c, scalar, kAdvance).advanced;
    std::vector<std::byte> bytes(3 * 3 * (scalar == Scalar::kF64 ? 8 : 4));
    scene->read_positions({.first = 0, .stride = 1, .count = 3}, bytes);
    Positions expected = c.start[0];
    for (size_t v = 0; v < 3; ++v)
      for (size_t k = 0; k < 3; ++k)
        expected[v][k] = scalar == Scalar::kF64
                             ? blend(c.start[0][v][k], c.end[0][v][k], a)
                             : blend(static_cast<float>(c.start[0][v][k]), static_cast<float>(c.end[0][v][k]), a);
    EXPECT_EQ(pack(expected, scalar), bytes);
  }
}

TEST_F(Stepping, OptionsThatCannotBeAreRefused) {
  const Case c = falling(1, -1);
  const auto refused = [&](const SceneSpec& spec, const std::function<void(FrameInput&)>& set) {
    const auto scene = scene_at_start(c, spec);
    return refused_field([&] { go(*scene, c, Scalar::kF64, set); });
  };
  const SceneSpec sound = ccd(c, Scalar::kF64);
  SceneSpec discrete = sound, one_kind = sound;
  discrete.mode = Mode::kDcd;
  one_kind.kinds.edge_edge = false;
  EXPECT_EQ("advance", refused(discrete, kAdvance));
  EXPECT_EQ("advance", refused(one_kind, kAdvance));
  EXPECT_EQ("advance", refused(sound, [](FrameInput& f) { f.advance = true, f.accuracy = Accuracy::kGuarded; }));
  EXPECT_EQ("ignore_separating", refused(discrete, [](FrameInput& f) { f.ignore_separating = true; }));
  EXPECT_EQ("ignore_separating",
            refused(sound, [](FrameInput& f) { f.ignore_separating = true, f.accuracy = Accuracy::kFast; }));
  EXPECT_EQ("start_fraction", refused(discrete, [](FrameInput& f) { f.start_fraction = 0.5; }));
  for (const double bad : {-0.1, 1.1, std::nan("")})
    EXPECT_EQ("start_fraction", refused(sound, [&](FrameInput& f) { f.start_fraction = bad; }));
  const auto fresh = Detector::create(sound);
  EXPECT_EQ("start_fraction",
            refused_field([&] { go(*fresh, c, Scalar::kF64, [](FrameInput& f) { f.start_fraction = 0.5; }); }));
  SceneSpec bad = sound;
  bad.min_separation = -1;
  EXPECT_EQ("min_separation", refused_field([&] { Detector::create(bad); }));
  discrete.min_separation = 1;
  EXPECT_EQ("min_separation", refused_field([&] { Detector::create(discrete); }));
}

TEST_F(Stepping, ATrialLeavesTheSceneAsItWas) {
  for (const Scalar scalar : kFormats) {
    const Case c = falling(1, -1), other = falling(1, -3);
    const auto scene = scene_at_start(c, ccd(c, scalar));
    const auto trial = [](FrameInput& frame) { frame.trial = true; };
    const FrameResult first = go(*scene, c, scalar, trial);
    EXPECT_NEAR(0.5, first.earliest_toi, 1e-6);
    EXPECT_NEAR(0.25, go(*scene, other, scalar, trial).earliest_toi, 1e-6);
    EXPECT_EQ(first.earliest_toi, go(*scene, c, scalar, [](FrameInput&) {}).earliest_toi);
  }
}

// Else a scene that is created again would be told otherwise than the one that was lost.
TEST_F(Stepping, AnAdvanceIsToldTheSameWhateverTheSceneWentThroughBefore) {
  for (const Scalar scalar : kFormats) {
    const Case c = falling(1, -1), far = falling(1, -1000);
    const FrameResult first = go(*scene_at_start(c, ccd(c, scalar)), c, scalar, kAdvance);
    const auto scene = scene_at_start(c, ccd(c, scalar));
    go(*scene, far, scalar, [](FrameInput& frame) { frame.advance = frame.trial = true; });
    const FrameResult later = go(*scene, c, scalar, kAdvance);
    EXPECT_TRUE(same_contacts(first, later));
    EXPECT_EQ(first.earliest_toi, later.earliest_toi);
    EXPECT_EQ(first.advanced, later.advanced);
  }
}

// The same as a frame with the positions of that point as its start.
TEST_F(Stepping, AFrameMayBeginOnTheWayOfTheLast) {
  for (const Scalar scalar : kFormats)
    for (const bool after_trial : {false, true}) {
      const Case c = falling(1, -1), on = falling(0.5, -0.5);
      const auto scene = scene_at_start(c, ccd(c, scalar));
      go(*scene, c, scalar, [&](FrameInput& frame) { frame.trial = after_trial; });
      const FrameResult begun = go(*scene, on, scalar, [](FrameInput& frame) { frame.start_fraction = 0.25; });
      EXPECT_NEAR(0.5, begun.earliest_toi, 1e-6);
      // From there on, without new positions: to where the last frame was half-way.
      FrameInput none;
      none.start_fraction = 0.5;
      EXPECT_EQ(0u, scene->detect(none).counts.contacts.edge_edge) << "both triangles stand still";
      const FrameResult back = go(*scene, falling(0, 1), scalar, [](FrameInput&) {});
      EXPECT_EQ(0, back.earliest_toi) << "half-way they touch";
    }
}

TEST_F(Stepping, ARefusedFrameLeavesNoWayToBeginOn) {
  const Case c = falling(1, -1);
  const auto scene = scene_at_start(c, ccd(c, Scalar::kF64));
  SceneSpec small = ccd(c, Scalar::kF64);
  Case bad = c;
  bad.end[0][0][0] = std::nan("");
  EXPECT_EQ("updates[0].end", refused_field([&] { go(*scene, bad, Scalar::kF64, [](FrameInput&) {}); }).substr(0, 14));
  EXPECT_NEAR(0.5, go(*scene, c, Scalar::kF64, [](FrameInput&) {}).earliest_toi, 1e-6);
}

// Small simulations; tests/bench/advance runs them for thousands of steps.
class Simulations : public OnBackend<::testing::TestWithParam<Simulation>> {};
INSTANTIATE_TEST_SUITE_P(All, Simulations, ::testing::ValuesIn(simulations()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(Simulations, NeverCross) {
  const auto play = [](Scalar scalar, AdvanceMode mode) {
    Simulator simulator(GetParam().make(), kBackend, scalar, mode);
    SceneSpec crossing = settings(Mode::kDcd, Accuracy::kExact, scalar);
    crossing.kinds = {.triangle_triangle = true};
    const auto judge = Detector::create(spec_for(simulator.bodies().meshes, crossing));
    std::vector<double> of_largest;
    for (int i = 0; i < 60; ++i) {
      const Simulator::Step step = simulator.step();
      const FrameResult found = judge->detect(Frame(simulator.last_way(), Mode::kDcd, scalar, i == 0).input());
      ASSERT_EQ(0u, found.triangle_triangle.size()) << "step " << i;
      EXPECT_LE(step.advanced, step.way);
      if (mode == AdvanceMode::kAllOrOne) {
        EXPECT_LE(step.advanced, step.earliest_toi);
      }
      if (step.earliest_toi > 0 && step.earliest_toi < 1) of_largest.push_back(step.advanced / step.earliest_toi);
    }
    if (of_largest.empty() || mode != AdvanceMode::kAllOrOne) return;
    std::sort(of_largest.begin(), of_largest.end());
    EXPECT_GE(of_largest[of_largest.size() / 2], 0.99);
  };
  play(Scalar::kF32, AdvanceMode::kAllOrOne);
  play(Scalar::kF64, AdvanceMode::kAllOrOne);
  play(Scalar::kF32, AdvanceMode::kPerVertex);
  play(Scalar::kF64, AdvanceMode::kPerMesh);
}

// All that comes near on the ways of a few steps, in integer arithmetic.
TEST_F(Stepping, KeepsTheSeparationOnTheWholeWay) {
  for (const Scalar scalar : kFormats) {
    Simulator simulator(simulation("soft_boxes").make(), kBackend, scalar);
    const double kept = simulator.bodies().min_separation;
    size_t judged = 0;
    for (int i = 0; i < 24; ++i) {
      simulator.step();
      if (i < 12) continue;  // they have not met yet
      const Case way = simulator.last_way();
      const FrameResult near = run_case(way, settings(Mode::kCcd, Accuracy::kCandidates, scalar, kept));
      const CaseJudge judge(way, Mode::kCcd, kept);
      EXPECT_TRUE(judge.vertex_triangle(near.vertex_triangle.elements).empty()) << "step " << i;
      EXPECT_TRUE(judge.edge_edge(near.edge_edge.elements).empty()) << "step " << i;
      judged += near.vertex_triangle.size() + near.edge_edge.size();
    }
    EXPECT_GT(judged, 0u);
  }
}

}  // namespace
}  // namespace collided::test
