// Scenes from the protocol to the engine, and refusals.
#include "server/convert/scene.hpp"

#include <gtest/gtest.h>

#include "server/convert/meshes.hpp"
#include "server/convert/options.hpp"
#include "server/errors.hpp"
#include "tests/server/convert/scene_refusals.hpp"
#include "tests/server/convert/scene_request.hpp"

namespace collided::server {
namespace {

TEST(ConvertScene, FillsDefaults) {
  const auto plan = parse_scene(request(), {}).plan;
  EXPECT_EQ(plan.engine.accuracy, Accuracy::kCertified);
  EXPECT_EQ(plan.engine.report, Report::kAll);
  EXPECT_EQ(plan.engine.delta, 0);
  EXPECT_EQ(plan.engine.scalar, Scalar::kF32);
  EXPECT_EQ(plan.engine.device.backend, Backend::kCpu);
  EXPECT_TRUE(plan.engine.kinds.vertex_triangle && plan.engine.kinds.edge_edge);
  EXPECT_TRUE(!plan.engine.kinds.triangle_triangle && !plan.engine.fields.has(ContactField::kWeights));
  EXPECT_EQ(plan.engine.memory_budget, Limits().max_scene_bytes);
  ASSERT_EQ(plan.engine.meshes.size(), 1u);
  EXPECT_EQ(plan.engine.meshes[0].triangles, (std::vector<TriangleCorners>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(plan.engine.meshes[0].collide_mask, ~0u);
  EXPECT_EQ(plan.fields.contact_bytes(), 8u + 16 + 8 + 8 + 1);
}

TEST(ConvertScene, TakesEveryLevelReportAndKind) {
  using Spec = pb::SceneSpec;
  EXPECT_EQ(scene_with([](Spec& s) { s.set_accuracy(pb::ACCURACY_CANDIDATES); }).accuracy, Accuracy::kCandidates);
  EXPECT_EQ(scene_with([](Spec& s) { s.set_accuracy(pb::ACCURACY_FAST); }).accuracy, Accuracy::kFast);
  EXPECT_EQ(scene_with([](Spec& s) { s.set_accuracy(pb::ACCURACY_GUARDED); }).accuracy, Accuracy::kGuarded);
  EXPECT_EQ(scene_with([](Spec& s) { s.set_accuracy(pb::ACCURACY_CERTIFIED); }).accuracy, Accuracy::kCertified);
  EXPECT_EQ(scene_with([](Spec& s) { s.set_accuracy(pb::ACCURACY_EXACT); }).accuracy, Accuracy::kExact);
  EXPECT_EQ(scene_with([](Spec& s) { s.set_report(pb::REPORT_EARLIEST_ONLY); }).report, Report::kEarliestOnly);
  EXPECT_EQ(scene_with([](Spec& s) { s.set_report(pb::REPORT_ANY_HIT); }).report, Report::kAnyHit);
  EXPECT_EQ(scene_with([](Spec& s) { s.set_delta(1e-6); }).delta, 1e-6);
  const auto triangles = scene_with([](Spec& s) {
    s.set_mode(pb::DETECTION_MODE_DCD);
    s.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  });
  EXPECT_TRUE(triangles.kinds.triangle_triangle && !triangles.kinds.vertex_triangle && !triangles.kinds.edge_edge);
}

TEST(ConvertScene, TakesEveryEngine) {
  EXPECT_EQ(std::size(kEngines), static_cast<size_t>(pb::BroadPhaseEngine_ARRAYSIZE));
  for (const auto& [message, engine] : kEngines) {
    const auto wanted = request_with([m = message](pb::SceneSpec& s) { s.set_broad_phase_engine(m); });
    EXPECT_EQ(parse_scene(wanted, {}).plan.engine.engine, engine) << message;
    EXPECT_EQ(shown(wanted).spec().broad_phase_engine(), message);
  }
}

TEST(ConvertScene, TakesWhetherListsAreReused) {
  for (const auto& [message, reuse] : {std::pair{pb::REUSE_UNSPECIFIED, Reuse::kAuto},
                                       std::pair{pb::REUSE_ON, Reuse::kOn}, std::pair{pb::REUSE_OFF, Reuse::kOff}}) {
    const auto wanted = request_with([m = message](pb::SceneSpec& s) { s.set_reuse(m); });
    EXPECT_EQ(parse_scene(wanted, {}).plan.engine.reuse, reuse);
    EXPECT_EQ(shown(wanted).spec().reuse(), message);
  }
  const auto bad = request_with([](pb::SceneSpec& s) { s.set_reuse(static_cast<pb::Reuse>(3)); });
  EXPECT_THROW(parse_scene(bad, {}), InvalidInput);
}

TEST(ConvertScene, TakesHowManyContactsAreExpected) {
  const auto wanted = request_with([](pb::SceneSpec& s) { s.set_expected_contacts(kMaxListLength); });
  EXPECT_EQ(parse_scene(wanted, {}).plan.engine.expected[ListLengths::kContacts], kMaxListLength);
  EXPECT_EQ(shown(wanted).spec().expected_contacts(), kMaxListLength);
}

TEST(ConvertScene, AnUnknownEngineIsRefusedWithItsValueAndTheLimit) {
  for (const int value : {-1, 9, 1000}) {
    const auto bad =
        request_with([&](pb::SceneSpec& s) { s.set_broad_phase_engine(static_cast<pb::BroadPhaseEngine>(value)); });
    try {
      parse_scene(bad, {});
      ADD_FAILURE() << "accepted: " << value;
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.field(), "spec.broad_phase_engine");
      EXPECT_EQ(e.what(), "spec.broad_phase_engine is " + std::to_string(value) +
                              ", but must be BROAD_PHASE_ENGINE_OCTREE, BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE, "
                              "BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE, "
                              "BROAD_PHASE_ENGINE_UNIFORM_GRID, "
                              "BROAD_PHASE_ENGINE_TWO_LEVEL_GRID, BROAD_PHASE_ENGINE_LBVH, "
                              "BROAD_PHASE_ENGINE_VSS or BROAD_PHASE_ENGINE_ALL_PAIRS");
    }
  }
}

TEST(ConvertScene, RequestIdAndLeaseAreTakenAndTold) {
  auto wanted = request();
  EXPECT_EQ(parse_scene(wanted, {}).lease_seconds, Limits().lease_seconds);
  wanted.set_request_id("mine");
  wanted.set_lease_seconds(3600);
  const auto parsed = parse_scene(wanted, {});
  EXPECT_EQ(parsed.request_id, "mine");
  EXPECT_EQ(parsed.lease_seconds, 3600);
  const auto told = shown(wanted);
  EXPECT_EQ(told.scene_id(), "id");
  EXPECT_EQ(told.resume_token(), "token");
  EXPECT_EQ(told.lease_seconds(), 7.5);
  EXPECT_EQ(told.state(), pb::SCENE_STATE_AWAITING_MESHES);
}

// A repeated request may ask for another lease, but for the same scene.
TEST(ConvertScene, TheFingerprintIsThatOfTheSpec) {
  auto same = request();
  same.set_lease_seconds(1);
  const uint64_t first = parse_scene(request(), {}).fingerprint;
  EXPECT_EQ(parse_scene(same, {}).fingerprint, first);
  EXPECT_NE(parse_scene(request_with([](pb::SceneSpec& s) { s.set_delta(1e-6); }), {}).fingerprint, first);
  const auto other = request_with([](pb::SceneSpec& s) { s.mutable_meshes(0)->set_triangles(triangle({0, 2, 1})); });
  EXPECT_NE(parse_scene(other, {}).fingerprint, first);
}

TEST(ConvertScene, TriangleCountIsTheWholeMesh) {
  const auto plan_with = [](uint32_t count) {
    return parse_scene(request_with([&](pb::SceneSpec& s) { s.mutable_meshes(0)->set_triangle_count(count); }), {})
        .plan;
  };
  for (const uint32_t all : {0u, 2u}) {
    EXPECT_EQ(plan_with(all).meshes[0].triangles, 2u);
    EXPECT_EQ(plan_with(all).meshes[0].awaited, 0u);
  }
  EXPECT_EQ(plan_with(5).meshes[0].triangles, 5u);
  EXPECT_EQ(plan_with(5).meshes[0].awaited, 3u);
  EXPECT_EQ(
      refusal_of(request_with([](pb::SceneSpec& s) { s.mutable_meshes(0)->set_triangle_count(1); })),
      "spec.meshes[0].triangle_count is 1, but spec.meshes[0].triangles already has 2: it is the total, including "
      "those that UploadMesh sends");
}

TEST(ConvertScene, ARefusedEnumNamesWhatCanBeUsed) {
  EXPECT_EQ(refusal_of(request_with([](pb::SceneSpec& s) { s.clear_mode(); })),
            "spec.mode is DETECTION_MODE_UNSPECIFIED, but must be DETECTION_MODE_DCD, DETECTION_MODE_CCD or "
            "DETECTION_MODE_DCD_AND_CCD");
  EXPECT_EQ(refusal_of(request_with([](pb::SceneSpec& s) { s.set_mode(static_cast<pb::DetectionMode>(77)); })),
            "spec.mode is 77, but must be DETECTION_MODE_DCD, DETECTION_MODE_CCD or DETECTION_MODE_DCD_AND_CCD");
  EXPECT_EQ(refusal_of(request_with([](pb::SceneSpec& s) { s.set_report(static_cast<pb::Report>(-1)); })),
            "spec.report is -1, but must be REPORT_ALL, REPORT_EARLIEST_ONLY or REPORT_ANY_HIT");
  EXPECT_EQ(refusal_of(request_with(
                [](pb::SceneSpec& s) { s.mutable_meshes(0)->set_motion(static_cast<pb::MeshMotion>(9)); })),
            "spec.meshes[0].motion is 9, but must be MESH_MOTION_DEFORMABLE, MESH_MOTION_STATIC or MESH_MOTION_RIGID");
}

TEST(ConvertScene, WhatCanNeverFitIsRefusedWithNeedAndBudget) {
  SceneDefaults defaults;
  defaults.limits.max_scene_bytes = 1 << 20;
  const auto many = request_with([](pb::SceneSpec& s) { s.mutable_meshes(0)->set_triangle_count(100'000); });
  const auto why = refusal_of(many, defaults);
  const uint64_t need = min_scene_bytes(parse_scene(request(), {}).plan.engine, 4, 100'000);
  EXPECT_EQ(why,
            "spec.memory_budget_bytes is 1048576 (max_scene_bytes), but the 4 vertices and 100000 triangles of "
            "spec.meshes need at least " +
                std::to_string(need) + " bytes");
  std::string bytes;
  for (int i = 0; i < 100'000; ++i) bytes += triangle({0, 1, 2});
  EXPECT_EQ(refusal_of(request_with([&](pb::SceneSpec& s) { s.mutable_meshes(0)->set_triangles(bytes); }), defaults),
            why);
  defaults.limits.max_scene_bytes = need;
  EXPECT_EQ(parse_scene(many, defaults).plan.min_bytes, need);
}

// 64 MiB of positions leave no room for the rest of the frame.
TEST(ConvertScene, AFirstFrameMustFitAMessageUnlessThereIsALocalSocket) {
  SceneDefaults defaults;
  defaults.limits.max_message_bytes = 12'000;
  const auto with_vertices = [](uint32_t count) {
    return request_with([&](pb::SceneSpec& s) { s.mutable_meshes(0)->set_vertex_count(count); });
  };
  EXPECT_EQ(refusal_of(with_vertices(999), defaults), "accepted");
  const auto why = refusal_of(with_vertices(1000), defaults);
  EXPECT_TRUE(why.starts_with("spec.meshes has 1000 vertices, whose positions, 12000 bytes,")) << why;
  EXPECT_NE(why.find("max-message-mb) is 12000"), std::string::npos) << why;
  defaults.local_socket = true;
  EXPECT_EQ(refusal_of(with_vertices(1000), defaults), "accepted");
}

// Between two frames triangles have no verdict, only boxes that overlap.
TEST(ConvertScene, ContinuousTrianglePairsAreCandidates) {
  const auto with_triangles = [](pb::Accuracy accuracy) {
    return request_with([&](pb::SceneSpec& s) {
      s.set_accuracy(accuracy);
      s.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
    });
  };
  const auto plan = parse_scene(with_triangles(pb::ACCURACY_CANDIDATES), {}).plan;
  EXPECT_TRUE(plan.engine.kinds.triangle_triangle && plan.engine.mode == Mode::kCcd);
  for (const auto accuracy : {pb::ACCURACY_UNSPECIFIED, pb::ACCURACY_FAST, pb::ACCURACY_EXACT})
    EXPECT_THROW(parse_scene(with_triangles(accuracy), {}), InvalidInput) << accuracy;
}

// A frame may override the level, so fields that the scene's own level does not compute are kept.
TEST(ConvertScene, FieldsDependOnTheModeAlone) {
  const auto bytes = [](pb::DetectionMode mode) {
    const auto wanted = request_with([&](pb::SceneSpec& spec) {
      spec.set_accuracy(pb::ACCURACY_CANDIDATES);
      spec.set_mode(mode);
    });
    return parse_scene(wanted, {}).plan.fields.contact_bytes();
  };
  EXPECT_EQ(bytes(pb::DETECTION_MODE_CCD), 8u + 16 + 8 + 8 + 1);
  EXPECT_EQ(bytes(pb::DETECTION_MODE_DCD), 8u + 16 + 8 + 1);
}

// Each is taken, and named where another value is refused.
TEST(ConvertScene, TakesEveryFieldOfTheProtocol) {
  const std::string refusal = refusal_of(request_with([](pb::SceneSpec& s) { s.mutable_fields()->Add(99); }));
  EXPECT_TRUE(refusal.starts_with("spec.fields[0] is 99, but must be ")) << refusal;
  const auto& fields = *pb::ContactField_descriptor();
  for (int i = 1; i < fields.value_count(); ++i) {
    const auto field = static_cast<pb::ContactField>(fields.value(i)->number());
    pb::SceneSpec asked, told;
    asked.add_fields(field);
    const OutputFields parsed = parse_fields(asked, Mode::kBoth);
    fill_fields(parsed, &told);
    ASSERT_EQ(told.fields_size(), 1) << fields.value(i)->name();
    EXPECT_EQ(told.fields(0), field);
    EXPECT_EQ(parsed.contact_bytes() > 0, field != pb::CONTACT_FIELD_PAIR_STATES);
    EXPECT_NE(refusal.find(fields.value(i)->name()), std::string::npos) << fields.value(i)->name();
  }
}

// From GUARDED on a thickness of 0 means touching, and triangle-triangle contacts have no distance.
TEST(ConvertScene, DiscreteScenesMayHaveNoThickness) {
  const auto thickness = [](pb::Accuracy accuracy, pb::ContactKind kind) {
    return scene_with([&](pb::SceneSpec& spec) {
             spec.set_mode(pb::DETECTION_MODE_DCD);
             spec.set_accuracy(accuracy);
             spec.add_kinds(kind);
           })
        .thickness;
  };
  EXPECT_EQ(thickness(pb::ACCURACY_GUARDED, pb::CONTACT_KIND_VERTEX_TRIANGLE), 0);
  EXPECT_EQ(thickness(pb::ACCURACY_EXACT, pb::CONTACT_KIND_EDGE_EDGE), 0);
  EXPECT_EQ(thickness(pb::ACCURACY_FAST, pb::CONTACT_KIND_TRIANGLE_TRIANGLE), 0);
  EXPECT_THROW(thickness(pb::ACCURACY_FAST, pb::CONTACT_KIND_EDGE_EDGE), InvalidInput);
}

TEST(ConvertScene, RefusesBadValues) {
  using Request = pb::CreateSceneRequest;
  const auto refuse = expect_refused<InvalidInput>;
  refuse("spec.mode", [](Request& r) { r.mutable_spec()->clear_mode(); });
  refuse("spec.thickness", [](Request& r) { r.mutable_spec()->set_thickness(-1); });
  refuse("spec.thickness", [](Request& r) { r.mutable_spec()->set_thickness(kNan); });
  for (const double delta : {-1.0, kNan, kInfinity})
    refuse("spec.delta", [&](Request& r) { r.mutable_spec()->set_delta(delta); });
  refuse("spec.accuracy", [](Request& r) { r.mutable_spec()->set_accuracy(static_cast<pb::Accuracy>(9)); });
  refuse("spec.report", [](Request& r) { r.mutable_spec()->set_report(static_cast<pb::Report>(-1)); });
  refuse("spec.meshes", [](Request& r) { r.mutable_spec()->clear_meshes(); });
  refuse("spec.meshes[0].name", [](Request& r) { r.mutable_spec()->mutable_meshes(0)->clear_name(); });
  refuse("spec.meshes[1].name", [](Request& r) { *r.mutable_spec()->add_meshes() = r.spec().meshes(0); });
  refuse("spec.meshes[0].triangles[1]", [](Request& r) { r.mutable_spec()->mutable_meshes(0)->set_vertex_count(3); });
  refuse("spec.meshes[0].triangles[0]", [](Request& r) {
    r.mutable_spec()->mutable_meshes(0)->set_triangles(triangle({0, 1, 1}));
  });
  refuse("spec.meshes[0].triangles", [](Request& r) { r.mutable_spec()->mutable_meshes(0)->set_triangles("12345"); });
  refuse("spec.meshes[0].triangles", [](Request& r) { r.mutable_spec()->mutable_meshes(0)->clear_triangles(); });
  refuse("spec.kinds[0]", [](Request& r) { r.mutable_spec()->add_kinds(pb::CONTACT_KIND_UNSPECIFIED); });
  refuse("spec.meshes[0].exclude_rings", [](Request& r) { r.mutable_spec()->mutable_meshes(0)->set_exclude_rings(9); });
  for (const double half : {-1.0, kNan, kInfinity, 1e300})
    refuse("spec.meshes[0].half_thickness",
           [&](Request& r) { r.mutable_spec()->mutable_meshes(0)->set_half_thickness(half); });
  for (const double distance : {-1.0, kNan, kInfinity})
    refuse("spec.rest_distance", [&](Request& r) { r.mutable_spec()->set_rest_distance(distance); });
  refuse("spec.expected_contacts", [](Request& r) { r.mutable_spec()->set_expected_contacts(kMaxListLength + 1); });
  refuse("spec.excluded_meshes[0]", [](Request& r) { r.mutable_spec()->add_excluded_meshes()->set_second(1); });
  refuse("request_id", [](Request& r) { r.set_request_id(std::string(65, 'x')); });
  for (const double lease : {-1.0, kNan}) refuse("lease_seconds", [&](Request& r) { r.set_lease_seconds(lease); });
}

TEST(ConvertScene, TakesAndTellsTheDevicesOfItsShards) {
  const auto wanted = request_with([](pb::SceneSpec& s) {
    for (int i = 0; i < 3; ++i) s.add_part_devices("cpu:0");
  });
  const ScenePlan plan = parse_scene(wanted, {}).plan;
  EXPECT_EQ(plan.engine.part_devices, std::vector<Device>(3));
  EXPECT_EQ(wish_of(plan).shards, plan.engine.part_devices);
  EXPECT_GT(plan.min_bytes, 2 * parse_scene(request(), {}).plan.min_bytes) << "each shard has all positions";
  EXPECT_EQ(shown(wanted).spec().part_devices_size(), 3);
  EXPECT_EQ(shown(wanted).spec().part_devices(2), "cpu:0");
}

TEST(ConvertScene, RefusesPartsThatCannotBe) {
  const auto refusal = [](int parts, const std::function<void(pb::SceneSpec&)>& change,
                          const SceneDefaults& defaults = {}) {
    return refusal_of(request_with([&](pb::SceneSpec& s) {
                        for (int i = 0; i < parts; ++i) s.add_part_devices("cpu:0");
                        change(s);
                      }),
                      defaults);
  };
  EXPECT_EQ(refusal(5, [](pb::SceneSpec&) {}), "spec.part_devices has 5 or more parts on cpu:0, more than 4");
  EXPECT_EQ(refusal(65, [](pb::SceneSpec&) {}), "spec.part_devices has 65 parts, more than 64");
  EXPECT_EQ(refusal(1, [](pb::SceneSpec& s) { s.add_part_devices("gpu"); }),
            "spec.part_devices[1] is \"gpu\", but must be cpu:0");
  EXPECT_EQ(refusal(1, [](pb::SceneSpec& s) { s.set_device("cpu:0"); }),
            "spec.device is \"cpu:0\", but spec.part_devices says where the scene lives");
  EXPECT_EQ(refusal(1, [](pb::SceneSpec& s) { s.set_backend(pb::BACKEND_CUDA); }),
            "spec.part_devices[0] is cpu:0, but spec.backend is BACKEND_CUDA");
  SceneDefaults both;
  both.devices.push_back({Backend::kCuda, 0});
  EXPECT_EQ(refusal(
                1, [](pb::SceneSpec& s) { s.add_part_devices("cuda:0"); }, both),
            "spec.part_devices[1] is cuda:0, but the first is cpu:0: parts are on one backend");
  EXPECT_EQ(refusal(1, [](pb::SceneSpec& s) { s.set_reuse(pb::REUSE_ON); }),
            "spec.reuse is ON, but a scene in parts has no lists of neighbours");
  pb::CreateScenesRequest set;
  *set.mutable_spec() = request().spec();
  set.mutable_spec()->add_part_devices("cpu:0");
  set.set_count(2);
  EXPECT_THROW(parse_scenes(set, {}), InvalidInput);
}

TEST(ConvertScene, RefusesWhatDoesNotGoTogether) {
  using Request = pb::CreateSceneRequest;
  const auto refuse = expect_refused<InvalidInput>;
  refuse("spec.thickness", [](Request& r) {
    r.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
    r.mutable_spec()->set_accuracy(pb::ACCURACY_FAST);
  });
  refuse("spec.kinds[1]", [](Request& r) {
    r.mutable_spec()->add_kinds(pb::CONTACT_KIND_EDGE_EDGE);
    r.mutable_spec()->add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  });
  refuse("spec.kinds[1]", [](Request& r) {
    r.mutable_spec()->add_kinds(pb::CONTACT_KIND_EDGE_EDGE);
    r.mutable_spec()->add_kinds(pb::CONTACT_KIND_EDGE_TRIANGLE);
  });
  refuse("spec.report", [](Request& r) {
    r.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
    r.mutable_spec()->set_report(pb::REPORT_EARLIEST_ONLY);
  });
  refuse("spec.report", [](Request& r) {
    r.mutable_spec()->set_accuracy(pb::ACCURACY_FAST);
    r.mutable_spec()->set_report(pb::REPORT_EARLIEST_ONLY);
  });
  refuse("spec.report", [](Request& r) {
    r.mutable_spec()->set_accuracy(pb::ACCURACY_CANDIDATES);
    r.mutable_spec()->set_report(pb::REPORT_ANY_HIT);
  });
}

// The rule is the engine's; fields and values are named as the client knows them.
TEST(ConvertScene, ARefusedOptionTellsWhatItDoesNotGoWith) {
  EXPECT_EQ(refusal_of(request_with([](pb::SceneSpec& s) {
              s.set_mode(pb::DETECTION_MODE_DCD);
              s.set_report(pb::REPORT_EARLIEST_ONLY);
            })),
            "spec.report is EARLIEST_ONLY, which needs CCD at GUARDED or above; spec.mode is DETECTION_MODE_DCD and "
            "spec.accuracy is ACCURACY_CERTIFIED");
  EXPECT_EQ(refusal_of(request_with([](pb::SceneSpec& s) {
              s.set_accuracy(pb::ACCURACY_CANDIDATES);
              s.set_report(pb::REPORT_ANY_HIT);
            })),
            "spec.report is ANY_HIT, which needs FAST or above; spec.mode is DETECTION_MODE_CCD and spec.accuracy is "
            "ACCURACY_CANDIDATES");
  EXPECT_EQ(
      refusal_of(request_with([](pb::SceneSpec& s) {
        s.add_kinds(pb::CONTACT_KIND_EDGE_EDGE);
        s.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
      })),
      "spec.kinds[1], CONTACT_KIND_TRIANGLE_TRIANGLE, is on, but only DCD tests triangle pairs; CCD lists them at "
      "CANDIDATES alone; spec.mode is DETECTION_MODE_CCD and spec.accuracy is ACCURACY_CERTIFIED");
  EXPECT_EQ(refusal_of(request_with([](pb::SceneSpec& s) {
              s.set_mode(pb::DETECTION_MODE_DCD);
              s.set_accuracy(pb::ACCURACY_FAST);
            })),
            "spec.thickness is 0; discrete detection at FAST needs a distance > 0");
  EXPECT_TRUE(refusal_of(request_with([](pb::SceneSpec& s) {
                s.set_thickness(-1);
              })).starts_with("spec.thickness is -1; it must be from 0 to "));
}

TEST(ConvertScene, HoldsTheLimitsAndTheBackend) {
  using Request = pb::CreateSceneRequest;
  expect_refused<LimitExceeded>("spec.meshes",
                                [](Request& r) { r.mutable_spec()->mutable_meshes(0)->set_vertex_count(~0u); });
  expect_refused<LimitExceeded>("spec.meshes", [](Request& r) {
    for (int i = 0; i < 16384; ++i) r.mutable_spec()->add_meshes()->set_name(std::to_string(i));
  });
  expect_refused<LimitExceeded>("spec.memory_budget_bytes",
                                [](Request& r) { r.mutable_spec()->set_memory_budget_bytes(~uint64_t{0}); });
  for (const double lease : {3601.0, kInfinity})
    expect_refused<LimitExceeded>("lease_seconds", [&](Request& r) { r.set_lease_seconds(lease); });
  expect_refused<FailedPrecondition>("spec.backend",
                                     [](Request& r) { r.mutable_spec()->set_backend(pb::BACKEND_CUDA); });
}

}  // namespace
}  // namespace collided::server
