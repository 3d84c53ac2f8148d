// The protocol's messages to engine types and back.
#include "server/convert/convert.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "server/errors.hpp"

namespace collided::server {
namespace {

std::string triangle(std::array<uint32_t, 3> corners) {
  return {reinterpret_cast<const char*>(corners.data()), sizeof(corners)};
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

pb::CreateSceneRequest request() {
  pb::CreateSceneRequest request;
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_CCD);
  auto* mesh = spec->add_meshes();
  mesh->set_name("cloth");
  mesh->set_vertex_count(4);
  mesh->set_triangles(triangle({0, 1, 2}) + triangle({0, 2, 3}));
  return request;
}

template <class Error>
void expect_refused(const std::string& field, const std::function<void(pb::CreateSceneRequest&)>& change) {
  auto bad = request();
  change(bad);
  try {
    parse_scene(bad, {});
    ADD_FAILURE() << "accepted: " << field;
  } catch (const Error& e) {
    EXPECT_EQ(e.field(), field) << e.what();
    EXPECT_NE(std::string(e.what()).find(field), std::string::npos) << e.what();
  }
}

pb::CreateSceneRequest request_with(const std::function<void(pb::SceneSpec&)>& change) {
  auto wanted = request();
  change(*wanted.mutable_spec());
  return wanted;
}

SceneSpec scene_with(const std::function<void(pb::SceneSpec&)>& change) {
  return parse_scene(request_with(change), {}).engine;
}

TEST(ConvertScene, FillsDefaults) {
  const auto plan = parse_scene(request(), {});
  EXPECT_EQ(plan.engine.accuracy, Accuracy::kCertified);
  EXPECT_EQ(plan.engine.report, Report::kAll);
  EXPECT_EQ(plan.engine.delta, 0);
  EXPECT_EQ(plan.engine.scalar, Scalar::kF32);
  EXPECT_EQ(plan.engine.backend, Backend::kCpu);
  EXPECT_TRUE(plan.engine.vertex_triangle && plan.engine.edge_edge);
  EXPECT_TRUE(!plan.engine.triangle_triangle && !plan.engine.weights);
  EXPECT_EQ(plan.engine.memory_budget, Limits().max_scene_bytes);
  ASSERT_EQ(plan.engine.meshes.size(), 1u);
  EXPECT_EQ(plan.engine.meshes[0].triangles, (Scene::Triangles{{0, 1, 2}, {0, 2, 3}}));
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
  EXPECT_TRUE(triangles.triangle_triangle && !triangles.vertex_triangle && !triangles.edge_edge);
}

constexpr std::pair<pb::BroadPhaseEngine, Engine> kEngines[] = {
    {pb::BROAD_PHASE_ENGINE_UNSPECIFIED, Engine::kAuto},
    {pb::BROAD_PHASE_ENGINE_OCTREE, Engine::kOctree},
    {pb::BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE, Engine::kTopDown},
    {pb::BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE, Engine::kBottomUp},
    {pb::BROAD_PHASE_ENGINE_UNIFORM_GRID, Engine::kUniformGrid},
    {pb::BROAD_PHASE_ENGINE_TWO_LEVEL_GRID, Engine::kTwoLevelGrid},
    {pb::BROAD_PHASE_ENGINE_LBVH, Engine::kLbvh}};

TEST(ConvertScene, TakesEveryEngine) {
  EXPECT_EQ(std::size(kEngines), static_cast<size_t>(pb::BroadPhaseEngine_ARRAYSIZE));
  for (const auto& [message, engine] : kEngines) {
    const auto wanted = request_with([m = message](pb::SceneSpec& s) { s.set_broad_phase_engine(m); });
    EXPECT_EQ(parse_scene(wanted, {}).engine.engine, engine) << message;
    pb::Scene scene;
    fill_scene(Scene("s", parse_scene(wanted, {}), 1), &scene);
    EXPECT_EQ(scene.spec().broad_phase_engine(), message);
  }
}

TEST(ConvertScene, AnUnknownEngineIsRefusedWithItsValueAndTheLimit) {
  for (const int value : {-1, 7, 1000}) {
    const auto bad =
        request_with([&](pb::SceneSpec& s) { s.set_broad_phase_engine(static_cast<pb::BroadPhaseEngine>(value)); });
    try {
      parse_scene(bad, {});
      ADD_FAILURE() << "accepted: " << value;
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.field(), "spec.broad_phase_engine");
      EXPECT_EQ(e.what(), "spec.broad_phase_engine is " + std::to_string(value) + ", but must be from 0 to 6");
    }
  }
}

// Between two frames triangles have no verdict, only boxes that overlap.
TEST(ConvertScene, ContinuousTrianglePairsAreCandidates) {
  const auto with_triangles = [](pb::Accuracy accuracy) {
    return request_with([&](pb::SceneSpec& s) {
      s.set_accuracy(accuracy);
      s.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
    });
  };
  const auto plan = parse_scene(with_triangles(pb::ACCURACY_CANDIDATES), {});
  EXPECT_TRUE(plan.engine.triangle_triangle && plan.engine.mode == Mode::kCcd);
  for (const auto accuracy : {pb::ACCURACY_UNSPECIFIED, pb::ACCURACY_FAST, pb::ACCURACY_EXACT})
    EXPECT_THROW(parse_scene(with_triangles(accuracy), {}), InvalidInput) << accuracy;
}

// A frame may override the level, so that what the scene's own does not compute is wanted all the same.
TEST(ConvertScene, FieldsDependOnTheModeAlone) {
  const auto bytes = [](pb::DetectionMode mode) {
    const auto wanted = request_with([&](pb::SceneSpec& spec) {
      spec.set_accuracy(pb::ACCURACY_CANDIDATES);
      spec.set_mode(mode);
    });
    return parse_scene(wanted, {}).fields.contact_bytes();
  };
  EXPECT_EQ(bytes(pb::DETECTION_MODE_CCD), 8u + 16 + 8 + 8 + 1);
  EXPECT_EQ(bytes(pb::DETECTION_MODE_DCD), 8u + 16 + 8 + 1);
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

TEST(ConvertScene, NamesWhatIsNotServed) {
  using Request = pb::CreateSceneRequest;
  const auto refuse = expect_refused<Unimplemented>;
  refuse("request_id", [](Request& r) { r.set_request_id("x"); });
  refuse("spec.position_format", [](Request& r) { r.mutable_spec()->set_position_format(pb::POSITION_FORMAT_Q16); });
  refuse("spec.fields[0]", [](Request& r) { r.mutable_spec()->add_fields(pb::CONTACT_FIELD_NORMAL); });
  refuse("spec.meshes[0].motion",
         [](Request& r) { r.mutable_spec()->mutable_meshes(0)->set_motion(pb::MESH_MOTION_RIGID); });
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
  expect_refused<FailedPrecondition>("spec.backend",
                                     [](Request& r) { r.mutable_spec()->set_backend(pb::BACKEND_CUDA); });
}

// Checks a frame of a scene that `scene` changes from the default; empty if it is accepted.
std::string refused_field(const std::function<void(pb::SceneSpec&)>& scene,
                          const std::function<void(pb::Frame&)>& set) {
  pb::Frame frame;
  set(frame);
  try {
    parse_frame(frame, scene_with(scene));
  } catch (const InvalidInput& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with(e.field() + " is ")) << e.what();
    return e.field();
  }
  return "";
}

TEST(ConvertFrame, AbsentOverridesAreLeftToTheScene) {
  const auto input = parse_frame({}, scene_with([](pb::SceneSpec& s) { s.set_accuracy(pb::ACCURACY_EXACT); }));
  EXPECT_FALSE(input.accuracy || input.delta || input.report);
}

TEST(ConvertFrame, OverridesReachTheEngine) {
  pb::Frame frame;
  frame.set_accuracy(pb::ACCURACY_GUARDED);
  frame.set_delta(0);
  frame.set_report(pb::REPORT_ANY_HIT);
  const auto input = parse_frame(frame, scene_with([](pb::SceneSpec& s) { s.set_delta(1); }));
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

TEST(ConvertResult, ChunksAreBoundedAndCarryTheFieldsAskedFor) {
  FrameResult result;
  Topology topology;
  topology.triangles = {{0, 1, 2}};
  topology.edges = {{0, 1}, {3, 4}};
  for (uint32_t i = 0; i < 5; ++i) result.vertex_triangle.elements.push_back({3 + i, 0});
  result.vertex_triangle.toi = {0, 0.1, 0.2, 0.3, 0.4};
  result.edge_edge.elements = {{0, 1}};
  result.edge_edge.toi = {0.5};
  const OutputFields fields{.stencils = true, .toi = true};
  const auto chunks = make_chunks(result, topology, fields, 2 * fields.contact_bytes());
  ASSERT_EQ(chunks.size(), 4u);
  EXPECT_EQ(chunks[0].count(), 2u);
  EXPECT_EQ(chunks[2].count(), 1u);
  EXPECT_EQ(chunks[3].kind(), pb::CONTACT_KIND_EDGE_EDGE);
  EXPECT_TRUE(chunks[0].elements().empty());
  EXPECT_EQ(array_bytes(chunks), 6 * fields.contact_bytes());
  double toi = 0;
  std::memcpy(&toi, chunks[2].toi().data(), 8);
  EXPECT_EQ(toi, 0.4);
  std::array<uint32_t, 4> stencil{};
  std::memcpy(stencil.data(), chunks[2].stencils().data(), 16);
  EXPECT_EQ(stencil, (std::array<uint32_t, 4>{7, 0, 1, 2}));
  std::memcpy(stencil.data(), chunks[3].stencils().data(), 16);
  EXPECT_EQ(stencil, (std::array<uint32_t, 4>{0, 1, 3, 4}));
}

TEST(ConvertResult, WhatWasNotComputedIsLeftOut) {
  FrameResult result;
  Topology topology;
  topology.triangles = {{0, 1, 2}, {3, 4, 5}};
  result.vertex_triangle.elements = {{3, 0}};
  result.triangle_triangle.elements = {{0, 1}};
  result.triangle_triangle.flags = {kFlagCertified};
  const OutputFields fields{
      .elements = true, .stencils = true, .toi = true, .distance = true, .weights = true, .flags = true};
  const auto chunks = make_chunks(result, topology, fields, 1000);
  ASSERT_EQ(chunks.size(), 2u);
  EXPECT_EQ(array_bytes({chunks[0]}), 8u + 16);
  EXPECT_EQ(chunks[1].kind(), pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  EXPECT_EQ(array_bytes({chunks[1]}), 8u + 1);
  EXPECT_EQ(chunks[1].flags(), "\1");
}

TEST(ConvertResult, DoneTellsWhatTheStepCost) {
  FrameResult result;
  result.replays = 1;
  result.allocations = 2;
  result.graph_launches = 3;
  result.step_milliseconds = 0.25;
  for (const auto& [message, engine] : kEngines) {
    result.engine = engine;
    pb::FrameDone done;
    fill_done(result, {}, &done);
    EXPECT_EQ(done.metrics().replays(), 1u);
    EXPECT_EQ(done.metrics().allocations(), 2u);
    EXPECT_EQ(done.metrics().graph_launches(), 3u);
    EXPECT_EQ(done.metrics().step_milliseconds(), 0.25);
    EXPECT_EQ(done.metrics().broad_phase_engine(), message);
  }
}

TEST(ConvertResult, DoneTellsTotalsCountsAndWarnings) {
  FrameResult result;
  result.vertex_triangle.elements = {{3, 0}};
  result.triangle_triangle.elements = {{0, 1}, {0, 2}};
  result.counts.contacts_tt = 2;
  result.counts.survivors_vt = 3;
  result.counts.survivors_ee = 4;
  result.counts.exact_decisions = 5;
  result.earliest_toi = 0.5;
  result.any_contact = true;
  pb::FrameDone done;
  fill_done(result, {}, &done);
  EXPECT_EQ(done.contact_count(), 3u);
  EXPECT_TRUE(done.any_contact());
  EXPECT_EQ(done.earliest_toi(), 0.5);
  EXPECT_EQ(done.metrics().counts().contacts_triangle_triangle(), 2u);
  EXPECT_EQ(done.metrics().counts().survivors_vertex_triangle(), 3u);
  EXPECT_EQ(done.metrics().counts().survivors_edge_edge(), 4u);
  EXPECT_EQ(done.metrics().counts().exact_decisions(), 5u);
  EXPECT_TRUE(done.metrics().warnings().empty());
  result.input_resolution = true;
  fill_done(result, {}, &done);
  ASSERT_EQ(done.metrics().warnings_size(), 1);
  EXPECT_EQ(done.metrics().warnings(0), pb::FRAME_WARNING_INPUT_RESOLUTION);
}

}  // namespace
}  // namespace collided::server
