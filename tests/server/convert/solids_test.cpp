// Solids, and what is asked of them, from the protocol to the engine.
#include <gtest/gtest.h>

#include "server/convert/frame.hpp"
#include "server/refusals/field_path.hpp"
#include "tests/server/convert/scene_refusals.hpp"

namespace collided::server {
namespace {

using Change = std::function<void(pb::SceneSpec&)>;

// A tetrahedron that is a solid, and asks for all that solids give.
pb::CreateSceneRequest request_of_solid(const Change& change = [](pb::SceneSpec&) {}) {
  return request_with([&](pb::SceneSpec& s) {
    s.set_mode(pb::DETECTION_MODE_DCD);
    s.mutable_meshes(0)->set_triangles(triangle({0, 2, 1}) + triangle({0, 1, 3}) + triangle({1, 2, 3}) +
                                       triangle({2, 0, 3}));
    s.mutable_meshes(0)->set_solid(true);
    s.add_kinds(pb::CONTACT_KIND_VERTEX_TRIANGLE);
    s.add_kinds(pb::CONTACT_KIND_VERTEX_SOLID);
    s.add_fields(pb::CONTACT_FIELD_ELEMENTS);
    s.add_fields(pb::CONTACT_FIELD_PAIR_STATES);
    s.add_fields(pb::CONTACT_FIELD_SIGNED_DISTANCE);
    change(s);
  });
}

std::string refusal(const Change& change) { return refusal_of(request_of_solid(change)); }
void make_hollow(pb::SceneSpec& spec) { spec.mutable_meshes(0)->set_solid(false); }

TEST(ConvertSolids, AreTakenAndTold) {
  const auto wanted = request_of_solid();
  const ScenePlan plan = parse_scene(wanted, {}).plan;
  EXPECT_TRUE(plan.engine.meshes[0].solid && plan.engine.kinds.vertex_solid && plan.engine.pair_states);
  EXPECT_EQ(plan.engine.fields, (FieldSet{ContactField::kElements, ContactField::kSignedDistance}));
  EXPECT_EQ(plan.fields.contact_bytes(), sizeof(uint32_t[2]) + sizeof(double));
  const pb::SceneSpec told = shown(wanted).spec();
  EXPECT_TRUE(told.meshes(0).solid());
  EXPECT_EQ(std::vector<int>(told.kinds().begin(), told.kinds().end()),
            (std::vector<int>{pb::CONTACT_KIND_VERTEX_TRIANGLE, pb::CONTACT_KIND_VERTEX_SOLID}));
  EXPECT_EQ(
      std::vector<int>(told.fields().begin(), told.fields().end()),
      (std::vector<int>{pb::CONTACT_FIELD_ELEMENTS, pb::CONTACT_FIELD_PAIR_STATES, pb::CONTACT_FIELD_SIGNED_DISTANCE}));
}

TEST(ConvertSolids, NoneUnlessTheyAreAskedFor) {
  const SceneSpec engine = scene_with([](pb::SceneSpec& s) { s.set_mode(pb::DETECTION_MODE_DCD); });
  EXPECT_FALSE(engine.meshes[0].solid || engine.kinds.vertex_solid || engine.pair_states);
  EXPECT_FALSE(engine.fields.has(ContactField::kSignedDistance));
}

TEST(ConvertSolids, WithoutOneNothingCanBeInsideIt) {
  EXPECT_EQ(refusal(make_hollow), "spec.kinds[1], CONTACT_KIND_VERTEX_SOLID, is on, but no mesh is a solid");
  const auto states_alone = [](pb::SceneSpec& s) {
    make_hollow(s);
    s.mutable_kinds()->RemoveLast();
  };
  EXPECT_EQ(refusal(states_alone), "spec.fields[1], CONTACT_FIELD_PAIR_STATES, is on, but no mesh is a solid");
  expect_refused<InvalidInput>("spec.fields[1]",
                               [&](pb::CreateSceneRequest& r) { r = request_of_solid(states_alone); });
}

TEST(ConvertSolids, AreNotInSetsInPartsAndInEncodedPositions) {
  const auto plain = [](pb::SceneSpec& s) { s.clear_kinds(), s.clear_fields(); };
  EXPECT_EQ(refusal([&](pb::SceneSpec& s) {
              plain(s);
              s.add_part_devices("cpu:0"), s.add_part_devices("cpu:0");
            }),
            "spec.meshes[0].solid is on, but no mesh of a scene in parts can be a solid");
  EXPECT_EQ(
      refusal([&](pb::SceneSpec& s) {
        plain(s);
        s.set_position_format(pb::POSITION_FORMAT_Q16);
        for (const double end : {0, 1})
          for (int k = 0; k < 3; ++k)
            (end == 0 ? s.mutable_quantization_box()->mutable_lower() : s.mutable_quantization_box()->mutable_upper())
                ->Add(end);
        s.set_thickness(0.25);
      }),
      "spec.meshes[0].solid is on, but no mesh of encoded positions can be a solid");
  pb::CreateScenesRequest set;
  *set.mutable_spec() = request_of_solid(plain).spec();
  set.set_count(2);
  try {
    parse_scenes(set, {});
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "spec.meshes[0].solid");
    EXPECT_STREQ(e.what(), "spec.meshes[0].solid is on, but no mesh of a set of worlds can be a solid");
  }
}

TEST(ConvertSolids, NeedFramesOfDcdThatDecide) {
  EXPECT_TRUE(refusal([](pb::SceneSpec& s) {
                s.set_mode(pb::DETECTION_MODE_CCD);
              }).starts_with("spec.kinds[1], CONTACT_KIND_VERTEX_SOLID, is on, but "));
  EXPECT_TRUE(refusal([](pb::SceneSpec& s) {
                s.set_mode(pb::DETECTION_MODE_CCD);
                s.mutable_kinds()->RemoveLast();
              }).starts_with("spec.fields[1], CONTACT_FIELD_PAIR_STATES, is on, but "));
  EXPECT_EQ(refusal([](pb::SceneSpec& s) {
              s.set_accuracy(pb::ACCURACY_CANDIDATES);
              s.mutable_kinds()->RemoveLast();
            }),
            "spec.fields[1], CONTACT_FIELD_PAIR_STATES, is on, but CANDIDATES decides of no pair whether it meets; "
            "spec.mode is DETECTION_MODE_DCD and spec.accuracy is ACCURACY_CANDIDATES");
}

TEST(ConvertSolids, AFrameOfCandidatesHasNoStates) {
  pb::Frame frame;
  frame.set_accuracy(pb::ACCURACY_CANDIDATES);
  const auto refused = [&](const Change& change) -> std::string {
    try {
      parse_frame(frame, {}, parse_scene(request_of_solid(change), {}).plan.engine);
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.field(), "frame.accuracy");
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refused([](pb::SceneSpec&) {}),
            "frame.accuracy is ACCURACY_CANDIDATES: CONTACT_KIND_VERTEX_SOLID of spec.kinds is on, but CANDIDATES "
            "decides of no vertex whether it is inside");
  EXPECT_EQ(refused([](pb::SceneSpec& s) { s.mutable_kinds()->RemoveLast(); }), "");
}

TEST(ConvertSolids, WhatAFirstFrameShowsOfOneIsRefusedByTheScenesField) {
  EXPECT_EQ(frame_path("meshes[1].solid"), "spec.meshes[1].solid");
  EXPECT_EQ(frame_path("edit.meshes[0].spec.solid"), "frame.edit.meshes[0].spec.solid");
}

}  // namespace
}  // namespace collided::server
