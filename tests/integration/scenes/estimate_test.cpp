// EstimateScene against CreateScene and what the scene then holds, sends and runs.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

using Parts = std::map<std::string, uint64_t>;
using Change = void (*)(pb::SceneSpec& spec);

grpc::Status estimate(Stub& stub, const pb::CreateSceneRequest& scene, pb::EstimateSceneResponse* response = nullptr) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::EstimateSceneRequest request;
  *request.mutable_spec() = scene.spec();
  pb::EstimateSceneResponse unread;
  return stub.EstimateScene(&context, request, response ? response : &unread);
}

pb::CreateSceneRequest request_with(Change change) {
  auto request = tip_request();
  change(*request.mutable_spec());
  return request;
}

template <class Message>
Parts parts_of(const Message& message) {
  Parts parts;
  for (const auto& part : message.memory()) parts[part.part()] += part.bytes();
  return parts;
}

uint64_t bytes_of(const Parts& parts) {
  uint64_t bytes = 0;
  for (const auto& [part, held] : parts) bytes += held;
  return bytes;
}

class Estimate : public testing::Test {
 protected:
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

void expect_parts(const Parts& told, const Parts& held) {
  for (const auto& [part, bytes] : told) {
    ASSERT_TRUE(held.contains(part)) << part;
    EXPECT_LE(bytes, held.at(part)) << part;
  }
  EXPECT_GE(bytes_of(told), bytes_of(held) / 2);
}

constexpr Change kSpecs[] = {
    [](pb::SceneSpec&) {},
    [](pb::SceneSpec& spec) { spec.set_accuracy(pb::ACCURACY_CANDIDATES); },
    [](pb::SceneSpec& spec) { spec.set_accuracy(pb::ACCURACY_FAST); },
    [](pb::SceneSpec& spec) { spec.set_accuracy(pb::ACCURACY_EXACT); },
    [](pb::SceneSpec& spec) { spec.set_mode(pb::DETECTION_MODE_DCD); },
    [](pb::SceneSpec& spec) {
      spec.set_mode(pb::DETECTION_MODE_DCD);
      spec.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
    },
    [](pb::SceneSpec& spec) { spec.add_kinds(pb::CONTACT_KIND_VERTEX_TRIANGLE); },
    [](pb::SceneSpec& spec) { spec.set_report(pb::REPORT_EARLIEST_ONLY); },
    [](pb::SceneSpec& spec) { spec.set_report(pb::REPORT_ANY_HIT); },
    [](pb::SceneSpec& spec) { spec.set_broad_phase_engine(pb::BROAD_PHASE_ENGINE_LBVH); },
    [](pb::SceneSpec& spec) {
      for (const auto field : {pb::CONTACT_FIELD_ELEMENTS, pb::CONTACT_FIELD_NORMAL, pb::CONTACT_FIELD_WEIGHTS})
        spec.add_fields(field);
    },
    [](pb::SceneSpec& spec) { spec.mutable_meshes(1)->set_no_self_contacts(true); },
    [](pb::SceneSpec& spec) { spec.set_mode(pb::DETECTION_MODE_DCD_AND_CCD); },
    [](pb::SceneSpec& spec) { spec.add_excluded_meshes()->set_second(1); },
    [](pb::SceneSpec& spec) {
      for (int i = 0; i < 500; ++i) *spec.mutable_meshes(0)->mutable_edges() += pack<uint32_t>({0, 1});
    }};

TEST_F(Estimate, TellsWhatTheSceneHoldsAndRuns) {
  for (const Change change : kSpecs) {
    const auto request = request_with(change);
    SCOPED_TRACE(request.spec().ShortDebugString());
    pb::EstimateSceneResponse told;
    const auto status = estimate(*stub_, request, &told);
    ASSERT_TRUE(status.ok()) << status.error_message();
    const auto made = made_scene(*stub_, request);
    EXPECT_EQ(told.spec().SerializeAsString(), made.spec().SerializeAsString());
    EXPECT_EQ(told.device(), made.device());
    EXPECT_EQ(told.vertex_count(), made.vertex_count());
    EXPECT_EQ(told.triangle_count(), made.triangle_count());
    pb::Frame frame = first_frame(0.5);  // finds nothing
    frame.mutable_updates(0)->clear_start_positions();
    pb::DetectFrameResponse answer;
    ASSERT_TRUE(detect(*stub_, made.scene_id(), frame, &answer).ok());
    pb::Scene scene;
    ASSERT_TRUE(get_scene(*stub_, made.scene_id(), &scene).ok());
    expect_parts(parts_of(told), parts_of(scene));
    std::vector<std::string> ran;
    for (const auto& stage : answer.done().metrics().stages()) ran.push_back(stage.stage());
    EXPECT_EQ(std::vector<std::string>(told.stages().begin(), told.stages().end()), ran);
    EXPECT_EQ(told.first_frame_bytes(), answer.done().metrics().bytes_in());
    EXPECT_EQ(told.frame_bytes(), told.first_frame_bytes() / 2);  // the floor is static
  }
}

TEST_F(Estimate, TellsTheBytesOfAContact) {
  for (const auto format : {pb::POSITION_FORMAT_F32, pb::POSITION_FORMAT_F64})
    for (const auto accuracy : {pb::ACCURACY_FAST, pb::ACCURACY_CERTIFIED}) {
      auto request = tip_request(format == pb::POSITION_FORMAT_F64);
      request.mutable_spec()->set_accuracy(accuracy);
      pb::EstimateSceneResponse told;
      ASSERT_TRUE(estimate(*stub_, request, &told).ok());
      pb::DetectFrameResponse answer;
      ASSERT_TRUE(
          detect(*stub_, make_scene(*stub_, request), first_frame(2, format == pb::POSITION_FORMAT_F64), &answer).ok());
      ASSERT_EQ(answer.done().contact_count(), 1u);
      EXPECT_EQ(told.contact_bytes().vertex_triangle(), answer.done().metrics().bytes_out());
      EXPECT_EQ(told.contact_bytes().edge_edge(), told.contact_bytes().vertex_triangle());
      EXPECT_EQ(told.contact_bytes().triangle_triangle(), 0u);
    }
}

TEST_F(Estimate, SendsNoContactsWhereOnlyTheirPresenceIsAskedFor) {
  pb::EstimateSceneResponse told;
  ASSERT_TRUE(
      estimate(*stub_, request_with([](pb::SceneSpec& spec) { spec.set_report(pb::REPORT_ANY_HIT); }), &told).ok());
  EXPECT_EQ(told.contact_bytes().SerializeAsString(), "");
}

TEST_F(Estimate, CreatesNothing) {
  pb::EstimateSceneResponse told;
  ASSERT_TRUE(estimate(*stub_, tip_request(), &told).ok());
  EXPECT_TRUE(list_scenes(*stub_).empty());
  EXPECT_EQ(Probe(daemon_).device_bytes(), 0);
}

TEST_F(Estimate, DeclaredTrianglesAreAsGoodAsTheirCorners) {
  auto declared = tip_request();
  for (auto& mesh : *declared.mutable_spec()->mutable_meshes()) {
    mesh.clear_triangles();
    mesh.set_triangle_count(1);
  }
  pb::EstimateSceneResponse of_declared, of_corners;
  ASSERT_TRUE(estimate(*stub_, declared, &of_declared).ok());
  ASSERT_TRUE(estimate(*stub_, tip_request(), &of_corners).ok());
  EXPECT_EQ(of_declared.SerializeAsString(), of_corners.SerializeAsString());
}

// Both calls refuse a spec alike: code, message, details.
TEST_F(Estimate, RefusesWhatCreateSceneRefuses) {
  constexpr Change kBad[] = {[](pb::SceneSpec& spec) { spec.clear_meshes(); },
                             [](pb::SceneSpec& spec) { spec.clear_mode(); },
                             [](pb::SceneSpec& spec) { spec.set_thickness(-1); },
                             [](pb::SceneSpec& spec) { spec.set_position_format(pb::POSITION_FORMAT_Q16); },
                             [](pb::SceneSpec& spec) { spec.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE); },
                             [](pb::SceneSpec& spec) { spec.set_memory_budget_bytes(1); },
                             [](pb::SceneSpec& spec) { spec.set_memory_budget_bytes(~uint64_t{0}); },
                             [](pb::SceneSpec& spec) { spec.set_backend(static_cast<pb::Backend>(9)); },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(1)->set_name("floor"); },
                             [](pb::SceneSpec& spec) {
                               spec.mutable_meshes(1)->set_triangles(pack<uint32_t>({0, 1, 3}));
                             },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(1)->set_vertex_count(~0u); },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(1)->set_triangle_count(~0u); },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(1)->set_exclude_rings(9); },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(1)->set_half_thickness(-1); },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(0)->set_half_thickness(std::nan("")); },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(0)->set_half_thickness(HUGE_VAL); },
                             [](pb::SceneSpec& spec) { spec.mutable_meshes(1)->set_half_thickness(1e300); },
                             [](pb::SceneSpec& spec) { spec.set_rest_distance(1); },
                             [](pb::SceneSpec& spec) { spec.add_excluded_meshes()->set_first(2); }};
  for (const Change change : kBad) {
    const auto request = request_with(change);
    const auto refused = create_scene(*stub_, request), status = estimate(*stub_, request);
    EXPECT_FALSE(status.ok()) << request.ShortDebugString();
    EXPECT_EQ(status.error_code(), refused.error_code()) << status.error_message();
    EXPECT_EQ(status.error_message(), refused.error_message());
    EXPECT_EQ(status.error_details(), refused.error_details());
  }
}

}  // namespace
}  // namespace collided::test
