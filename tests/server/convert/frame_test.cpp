// Frames from the protocol to the engine.
#include "server/convert/frame.hpp"

#include <gtest/gtest.h>

#include "server/convert/options.hpp"
#include "server/errors.hpp"
#include "tests/server/convert/scene_request.hpp"

namespace collided::server {
namespace {

// Checks a frame of a scene that `scene` changes from the default; empty if it is accepted.
std::string refused_field(const std::function<void(pb::SceneSpec&)>& scene,
                          const std::function<void(pb::Frame&)>& set) {
  pb::Frame frame;
  set(frame);
  try {
    parse_frame(frame, {}, scene_with(scene));
  } catch (const InvalidInput& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with(e.field() + " is ")) << e.what();
    return e.field();
  }
  return "";
}

TEST(ConvertFrame, AbsentOverridesAreLeftToTheScene) {
  const auto input = parse_frame({}, {}, scene_with([](pb::SceneSpec& s) { s.set_accuracy(pb::ACCURACY_EXACT); }));
  EXPECT_FALSE(input.accuracy || input.delta || input.report);
}

TEST(ConvertFrame, OverridesReachTheEngine) {
  pb::Frame frame;
  frame.set_accuracy(pb::ACCURACY_GUARDED);
  frame.set_delta(0);
  frame.set_report(pb::REPORT_ANY_HIT);
  const auto input = parse_frame(frame, {}, scene_with([](pb::SceneSpec& s) { s.set_delta(1); }));
  EXPECT_EQ(input.accuracy, Accuracy::kGuarded);
  EXPECT_EQ(input.delta, 0);
  EXPECT_EQ(input.report, Report::kAnyHit);
}

TEST(ConvertFrame, RefusesBadValues) {
  const auto any_scene = [](pb::SceneSpec&) {};
  for (const double delta : {-1.0, kNan, kInfinity})
    EXPECT_EQ(refused_field(any_scene, [&](pb::Frame& f) { f.set_delta(delta); }), "frame.delta");
  EXPECT_EQ(refused_field(any_scene, [](pb::Frame& f) { f.set_accuracy(static_cast<pb::Accuracy>(6)); }),
            "frame.accuracy");
  EXPECT_EQ(refused_field(any_scene, [](pb::Frame& f) { f.set_report(static_cast<pb::Report>(4)); }), "frame.report");
}

TEST(ConvertFrame, AnAdvanceGoesAllOrOneUnlessItsModeSaysOtherwise) {
  constexpr std::pair<pb::AdvanceMode, AdvanceMode> kModes[] = {{pb::ADVANCE_MODE_UNSPECIFIED, AdvanceMode::kAllOrOne},
                                                                {pb::ADVANCE_MODE_ALL_OR_ONE, AdvanceMode::kAllOrOne},
                                                                {pb::ADVANCE_MODE_PER_MESH, AdvanceMode::kPerMesh},
                                                                {pb::ADVANCE_MODE_PER_VERTEX, AdvanceMode::kPerVertex}};
  for (const auto& [message, engine] : kModes) {
    pb::Frame frame;
    frame.set_advance(true);
    frame.set_advance_mode(message);
    const auto input = parse_frame(frame, {}, scene_with([](pb::SceneSpec&) {}));
    EXPECT_TRUE(input.advance);
    EXPECT_EQ(input.advance_mode, engine) << message;
  }
}

TEST(ConvertFrame, OverridesMustGoTogetherWithTheScene) {
  const auto ccd = [](pb::SceneSpec&) {};
  const auto dcd = [](pb::SceneSpec& s) { s.set_mode(pb::DETECTION_MODE_DCD); };
  const auto candidates = [](pb::SceneSpec& s) { s.set_accuracy(pb::ACCURACY_CANDIDATES); };
  const auto triangles = [&](pb::SceneSpec& s) { candidates(s), s.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE); };
  const auto earliest_only = [](pb::SceneSpec& s) { s.set_report(pb::REPORT_EARLIEST_ONLY); };
  const auto fast = [](pb::Frame& f) { f.set_accuracy(pb::ACCURACY_FAST); };
  const auto earliest = [](pb::Frame& f) { f.set_report(pb::REPORT_EARLIEST_ONLY); };
  const auto any_hit = [](pb::Frame& f) { f.set_report(pb::REPORT_ANY_HIT); };
  const auto fast_earliest = [&](pb::Frame& f) { fast(f), earliest(f); };
  const auto fast_any_hit = [&](pb::Frame& f) { fast(f), any_hit(f); };
  EXPECT_EQ(refused_field(ccd, earliest), "");
  EXPECT_EQ(refused_field(ccd, fast), "");
  EXPECT_EQ(refused_field(ccd, fast_earliest), "frame.report");
  EXPECT_EQ(refused_field(dcd, earliest), "frame.report");
  EXPECT_EQ(refused_field(dcd, fast), "frame.accuracy");  // the thickness of the scene is 0
  EXPECT_EQ(refused_field(candidates, any_hit), "frame.report");
  EXPECT_EQ(refused_field(candidates, fast_any_hit), "");
  EXPECT_EQ(refused_field(candidates, fast), "");
  EXPECT_EQ(refused_field(triangles, fast), "frame.accuracy");
  EXPECT_EQ(refused_field(triangles, [](pb::Frame&) {}), "");
  EXPECT_EQ(refused_field(earliest_only, fast), "frame.accuracy");
  EXPECT_EQ(refused_field(earliest_only, fast_any_hit), "");
}

std::string refusal_of(const std::function<void(pb::SceneSpec&)>& scene, const std::function<void(pb::Frame&)>& set) {
  pb::Frame frame;
  set(frame);
  try {
    parse_frame(frame, {}, scene_with(scene));
  } catch (const InvalidInput& e) {
    return e.what();
  }
  return "accepted";
}

// The rule is the engine's; fields and values are named as the client knows them.
TEST(ConvertFrame, ARefusedOverrideTellsWhatItDoesNotGoWith) {
  const auto fast = [](pb::Frame& f) { f.set_accuracy(pb::ACCURACY_FAST); };
  EXPECT_EQ(refusal_of([](pb::SceneSpec& s) { s.set_mode(pb::DETECTION_MODE_DCD); },
                       [](pb::Frame& f) { f.set_report(pb::REPORT_EARLIEST_ONLY); }),
            "frame.report is EARLIEST_ONLY, which needs CCD at GUARDED or above; spec.mode is DETECTION_MODE_DCD and "
            "spec.accuracy is ACCURACY_CERTIFIED");
  EXPECT_EQ(refusal_of([](pb::SceneSpec&) {}, [&](pb::Frame& f) { fast(f), f.set_report(pb::REPORT_EARLIEST_ONLY); }),
            "frame.report is EARLIEST_ONLY, which needs CCD at GUARDED or above; spec.mode is DETECTION_MODE_CCD and "
            "frame.accuracy is ACCURACY_FAST");
  EXPECT_EQ(refusal_of([](pb::SceneSpec& s) { s.set_report(pb::REPORT_EARLIEST_ONLY); }, fast),
            "frame.accuracy is ACCURACY_FAST: spec.report is EARLIEST_ONLY, which needs CCD at GUARDED or above");
  EXPECT_EQ(refusal_of([](pb::SceneSpec& s) { s.set_mode(pb::DETECTION_MODE_DCD); }, fast),
            "frame.accuracy is ACCURACY_FAST: spec.thickness is 0; discrete detection at FAST needs a distance > 0");
  EXPECT_EQ(refusal_of(
                [](pb::SceneSpec& s) {
                  s.set_accuracy(pb::ACCURACY_CANDIDATES);
                  s.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
                },
                fast),
            "frame.accuracy is ACCURACY_FAST: CONTACT_KIND_TRIANGLE_TRIANGLE of spec.kinds is on, but only DCD tests "
            "triangle pairs; CCD lists them at CANDIDATES alone");
  EXPECT_TRUE(refusal_of([](pb::SceneSpec&) {}, [](pb::Frame& f) { f.set_delta(-1); })
                  .starts_with("frame.delta is -1; it must be from 0 to "));
}

TEST(ConvertFrame, AnAdvanceModeIsKnownAndOfAnAdvance) {
  const auto refusal = [](bool advance, int mode) {
    return refusal_of(
        [](pb::SceneSpec&) {},
        [&](pb::Frame& f) { f.set_advance(advance), f.set_advance_mode(static_cast<pb::AdvanceMode>(mode)); });
  };
  EXPECT_EQ(refusal(true, 4),
            "frame.advance_mode is 4, but must be ADVANCE_MODE_ALL_OR_ONE, ADVANCE_MODE_PER_MESH or "
            "ADVANCE_MODE_PER_VERTEX");
  EXPECT_EQ(refusal(false, -1).find("frame.advance_mode is -1, but must be"), 0u);
  EXPECT_EQ(refusal(false, pb::ADVANCE_MODE_PER_MESH),
            "frame.advance_mode is ADVANCE_MODE_PER_MESH, but frame.advance is false");
  EXPECT_EQ(refusal(false, pb::ADVANCE_MODE_ALL_OR_ONE),
            "frame.advance_mode is ADVANCE_MODE_ALL_OR_ONE, but frame.advance is false");
  EXPECT_EQ(refusal(false, pb::ADVANCE_MODE_UNSPECIFIED), "accepted");
}

TEST(ConvertFrame, LimitsAreOfAnAdvance) {
  const auto refusal = [](bool advance) {
    return refusal_of([](pb::SceneSpec&) {}, [&](pb::Frame& f) { f.set_advance(advance), f.set_limits(true); });
  };
  EXPECT_EQ(refusal(false), "frame.limits is on, but advance is off");
  EXPECT_EQ(refusal(true), "accepted");
}

TEST(ConvertFrame, PlacedPositionsComeBeforeThoseOfTheMessage) {
  const std::array<std::byte, 36> memory{};
  pb::Frame frame;
  frame.add_updates()->set_positions("of the message");
  frame.add_updates()->set_positions("of the message, too");
  const PlacedPositions placed[] = {{{}, memory, {}}, {memory, {}, memory}};
  const auto updates = parse_frame(frame, placed, scene_with([](pb::SceneSpec&) {})).updates;
  EXPECT_EQ(updates[0].end.data(), memory.data());
  EXPECT_TRUE(updates[0].start.empty());
  EXPECT_EQ(updates[1].start.data(), memory.data());
  EXPECT_EQ(updates[1].indices.data(), memory.data());
  EXPECT_EQ(updates[1].end.size(), frame.updates(1).positions().size());
}

TEST(ConvertFrame, UpdatesAreTakenAsTheyAre) {
  pb::Frame frame;
  frame.add_updates()->set_mesh(3);
  pb::MeshUpdate& sparse = *frame.add_updates();
  sparse.mutable_sparse()->set_indices("indices");
  sparse.set_start_positions("start");
  pb::MeshUpdate& rigid = *frame.add_updates();
  rigid.mutable_rigid()->set_matrix("matrix");
  rigid.mutable_rigid()->set_start_matrix("start");
  const auto updates = parse_frame(frame, {}, scene_with([](pb::SceneSpec&) {})).updates;
  ASSERT_EQ(updates.size(), 3u);
  EXPECT_EQ(updates[0].mesh, 3u);
  EXPECT_FALSE(updates[0].is_sparse || updates[2].is_sparse);
  EXPECT_TRUE(updates[1].is_sparse);
  EXPECT_EQ(updates[1].indices.size(), 7u);
  EXPECT_EQ(updates[1].start.size(), 5u);
  EXPECT_EQ(updates[2].transform.size(), 6u);
  EXPECT_EQ(updates[2].start_transform.size(), 5u);
}

TEST(ConvertFrame, ARefusalOfTheModeNamesIt) {
  pb::Frame frame;
  frame.set_mode(pb::DETECTION_MODE_DCD);
  const SceneSpec scene = scene_with([](pb::SceneSpec& s) {
    s.set_mode(pb::DETECTION_MODE_DCD_AND_CCD);
    s.set_report(pb::REPORT_EARLIEST_ONLY);
  });
  try {
    parse_frame(frame, {}, scene);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "frame.mode");
    EXPECT_STREQ(e.what(),
                 "frame.mode is DETECTION_MODE_DCD: spec.report is EARLIEST_ONLY, which needs CCD at GUARDED or above");
  }
}

TEST(ConvertFrame, RefusesWhatThisTransportDoesNotServe) {
  const auto field_of = [](const std::function<void(pb::MeshUpdate&)>& set) -> std::string {
    pb::Frame frame;
    frame.add_updates();
    set(*frame.add_updates());
    try {
      parse_frame(frame, {}, scene_with([](pb::SceneSpec&) {}));
    } catch (const InvalidInput& e) {
      return e.field();
    }
    return "";
  };
  EXPECT_EQ(field_of([](pb::MeshUpdate& u) { u.mutable_rigid(); }), "frame.updates[1].rigid.matrix");
  EXPECT_EQ(field_of([](pb::MeshUpdate& u) { u.mutable_shared_positions(); }), "frame.updates[1].shared_positions");
  EXPECT_EQ(field_of([](pb::MeshUpdate& u) { u.mutable_shared_start_positions(); }),
            "frame.updates[1].shared_start_positions");
  EXPECT_EQ(field_of([](pb::MeshUpdate& u) { u.mutable_sparse()->mutable_shared_indices(); }),
            "frame.updates[1].sparse.shared_indices");
  EXPECT_EQ(field_of([](pb::MeshUpdate& u) { u.mutable_sparse(); }), "");
}

TEST(EngineLabels, AreTheProtocolsNamesAndMadeOnce) {
  EXPECT_EQ(label_of(Engine::kTopDown), "top_down_octree");
  EXPECT_EQ(label_of(Engine::kAuto), "unspecified");
  EXPECT_EQ(label_of(EngineReason::kFirst), "first_frames");
  EXPECT_EQ(label_of(Engine::kUniformGrid).data(), label_of(Engine::kUniformGrid).data());
}

}  // namespace
}  // namespace collided::server
