// The protocol's messages to engine types and back.
#include "server/convert.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "server/errors.hpp"

namespace collided::server {
namespace {

std::string triangle(std::array<uint32_t, 3> corners) {
  return {reinterpret_cast<const char*>(corners.data()), sizeof(corners)};
}

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

TEST(ConvertScene, FillsDefaults) {
  const auto plan = parse_scene(request(), {});
  EXPECT_EQ(plan.engine.accuracy, Accuracy::kFast);
  EXPECT_EQ(plan.engine.scalar, Scalar::kF32);
  EXPECT_EQ(plan.engine.backend, Backend::kCpu);
  EXPECT_TRUE(plan.engine.vertex_triangle && plan.engine.edge_edge && !plan.engine.weights);
  EXPECT_EQ(plan.engine.memory_budget, Limits().max_scene_bytes);
  ASSERT_EQ(plan.engine.meshes.size(), 1u);
  EXPECT_EQ(plan.engine.meshes[0].triangles, (Scene::Triangles{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(plan.engine.meshes[0].collide_mask, ~0u);
  EXPECT_EQ(plan.fields.contact_bytes(), 8u + 16 + 8 + 8 + 1);
}

TEST(ConvertScene, LeavesOutWhatTheLevelDoesNotCompute) {
  auto wanted = request();
  wanted.mutable_spec()->set_accuracy(pb::ACCURACY_CANDIDATES);
  EXPECT_EQ(parse_scene(wanted, {}).fields.contact_bytes(), 8u + 16);
}

TEST(ConvertScene, RefusesBadValues) {
  using Request = pb::CreateSceneRequest;
  const auto refuse = expect_refused<InvalidInput>;
  refuse("spec.mode", [](Request& r) { r.mutable_spec()->clear_mode(); });
  refuse("spec.thickness", [](Request& r) { r.mutable_spec()->set_thickness(-1); });
  refuse("spec.thickness",
         [](Request& r) { r.mutable_spec()->set_thickness(std::numeric_limits<double>::quiet_NaN()); });
  refuse("spec.thickness", [](Request& r) { r.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD); });
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

TEST(ConvertScene, NamesWhatIsNotServed) {
  using Request = pb::CreateSceneRequest;
  const auto refuse = expect_refused<Unimplemented>;
  refuse("request_id", [](Request& r) { r.set_request_id("x"); });
  refuse("spec.delta", [](Request& r) { r.mutable_spec()->set_delta(1e-6); });
  refuse("spec.accuracy", [](Request& r) { r.mutable_spec()->set_accuracy(pb::ACCURACY_EXACT); });
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

}  // namespace
}  // namespace collided::server
