// CreateScenes and DetectBatch on the wire, good requests and hostile ones.

#include "tests/integration/batch/tip_set.hpp"

namespace collided::test {
namespace {

using Worlds = std::vector<uint64_t>;

class Batch : public testing::Test {
 protected:
  pb::DetectBatchResponse answer_to(const pb::DetectBatchRequest& batch) {
    pb::DetectBatchResponse response;
    const auto status = detect(*stub_, batch, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(response.answers_size(), batch.frames_size());
    return response;
  }
  /// The refusal of the one frame that `change` makes of a good one; the set goes on as if it had not been there.
  pb::FrameError refused(const std::string& set, const std::function<void(pb::SetFrame&)>& change) {
    pb::DetectBatchRequest batch;
    change(add_frame(batch, set, 2, {2, 0.5, 2}, false));
    const auto response = answer_to(batch);
    EXPECT_TRUE(response.answers(0).has_error());
    EXPECT_EQ(response.answers(0).contacts_size(), 0);
    return response.answers(0).error();
  }
  std::string started_set() {
    const auto set = make_set(*stub_, tip_set_request(3));
    pb::DetectBatchRequest batch;
    add_frame(batch, set, 1, {2, 0.5, 2}, true);
    EXPECT_EQ(hits(answer_to(batch).answers(0)), (Worlds{0, 2}));
    return set;
  }

  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(Batch, OneCallStepsAllWorlds) {
  pb::Scene scenes;
  ASSERT_TRUE(create_scenes(*stub_, tip_set_request(5), &scenes).ok());
  EXPECT_EQ(scenes.worlds(), 5u);
  EXPECT_EQ(scenes.vertex_count(), 6u) << "of each world";
  EXPECT_EQ(scenes.state(), pb::SCENE_STATE_READY);
  pb::DetectBatchRequest batch;
  add_frame(batch, scenes.scene_id(), 1, {2, 0.5, 4, 2, 0.25}, true);
  const auto first = answer_to(batch).answers(0);
  EXPECT_EQ(hits(first), (Worlds{0, 2, 3}));
  EXPECT_EQ(first.done().contact_count(), 3u);
  EXPECT_LE(first.done().earliest_toi(), 0.25);
  EXPECT_EQ(first.done().metrics().broad_phase_engine(), pb::BROAD_PHASE_ENGINE_LBVH);
  batch.clear_frames();
  auto& some = add_frame(batch, scenes.scene_id(), 2, {0.5, 3}, false);  // without the static floor
  some.add_worlds(1);
  some.add_worlds(4);
  EXPECT_EQ(hits(answer_to(batch).answers(0)), (Worlds{1}));
  pb::Scene now;
  ASSERT_TRUE(get_scene(*stub_, scenes.scene_id(), &now).ok());
  EXPECT_EQ(now.last_frame_id(), 2u);
  EXPECT_TRUE(delete_scene(*stub_, scenes.scene_id()).ok());
  EXPECT_EQ(answer_to(batch).answers(0).error().code(), grpc::NOT_FOUND);
}

TEST_F(Batch, SetsAndWorldsAreRefusedAlone) {
  const auto one = started_set(), other = started_set();
  const auto alone = make_scene(*stub_, tip_request());
  pb::DetectBatchRequest batch;
  auto& bad = add_frame(batch, one, 2, {2, 2, 2}, false);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bad.mutable_positions()->data() + (9 + 4) * sizeof(float), &nan, sizeof(nan));
  add_frame(batch, "nobody", 2, {2, 2, 2}, false);
  add_frame(batch, alone, 2, {2, 2, 2}, false);
  add_frame(batch, other, 2, {0.5, 0.5, 2}, false);
  const auto response = answer_to(batch);
  EXPECT_EQ(hits(response.answers(0)), (Worlds{0, 2}));
  ASSERT_EQ(response.answers(0).errors_size(), 1);
  const auto& error = response.answers(0).errors(0);
  EXPECT_EQ(error.world(), 1u);
  EXPECT_EQ(error.error().code(), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(error.error().field(), "frames[0].positions");
  EXPECT_TRUE(
      error.error().message().starts_with("frames[0].positions: world 1, mesh 1, vertex 1, coordinate y is nan"))
      << error.error().message();
  EXPECT_EQ(response.answers(1).error().code(), grpc::NOT_FOUND);
  EXPECT_EQ(response.answers(2).error().code(), grpc::FAILED_PRECONDITION);
  EXPECT_EQ(response.answers(2).error().field(), "frames[2].scene_id");
  EXPECT_EQ(hits(response.answers(3)), (Worlds{2}));
}

TEST_F(Batch, AWorldsFirstFrameHasEveryMesh) {
  const auto set = make_set(*stub_, tip_set_request(2));
  pb::DetectBatchRequest batch;
  add_frame(batch, set, 1, {2}, true).add_worlds(0);
  EXPECT_EQ(hits(answer_to(batch).answers(0)), (Worlds{0}));
  batch.clear_frames();
  add_frame(batch, set, 2, {2, 2}, false);
  const auto answer = answer_to(batch).answers(0);
  EXPECT_EQ(hits(answer), (Worlds{0}));
  ASSERT_EQ(answer.errors_size(), 1);
  EXPECT_NE(answer.errors(0).error().message().find("mesh 0 is missing"), std::string::npos)
      << answer.errors(0).error().message();
}

TEST_F(Batch, BadFramesNameFieldValueAndLimit) {
  const auto set = started_set();
  const auto expect = [&](const std::string& field, const std::string& part, auto change) {
    const auto error = refused(set, change);
    EXPECT_EQ(error.field(), "frames[0]." + field) << error.message();
    EXPECT_NE(error.message().find(part), std::string::npos) << error.message();
    EXPECT_EQ(error.message().find("frame."), std::string::npos) << error.message();
  };
  expect("positions", "has 107 bytes", [](pb::SetFrame& f) { f.mutable_positions()->pop_back(); });
  expect("positions", "has 0 bytes", [](pb::SetFrame& f) { f.clear_positions(); });
  expect("start_positions", "has 12 bytes, but positions has 108",
         [](pb::SetFrame& f) { f.set_start_positions(std::string(12, '\0')); });
  expect("worlds[1]", "is 1 after 1", [](pb::SetFrame& f) { f.add_worlds(1), f.add_worlds(1); });
  expect("worlds[0]", "is 3, but the set has 3 worlds", [](pb::SetFrame& f) { f.add_worlds(3); });
  expect("meshes[0]", "is 2, but the set has 2 meshes", [](pb::SetFrame& f) { f.add_meshes(2); });
  expect("frame_id", "is 1, but must be greater than 1", [](pb::SetFrame& f) { f.set_frame_id(1); });
  expect("frame_id", "more than", [](pb::SetFrame& f) { f.set_frame_id(~uint64_t{0}); });
  expect("mode", "DCD", [](pb::SetFrame& f) { f.set_mode(pb::DETECTION_MODE_DCD); });
  expect("delta", "-1", [](pb::SetFrame& f) { f.set_delta(-1); });
  expect("accuracy", "99", [](pb::SetFrame& f) { f.set_accuracy(static_cast<pb::Accuracy>(99)); });
  pb::DetectBatchRequest good;
  add_frame(good, set, 2, {2, 0.5, 0.5}, false);
  EXPECT_EQ(hits(answer_to(good).answers(0)), (Worlds{0}));
}

TEST_F(Batch, BadBatchesAreRefusedAsAWhole) {
  const auto set = started_set();
  const auto refuse = [&](const pb::DetectBatchRequest& batch) {
    pb::DetectBatchResponse response;
    return detect(*stub_, batch, &response);
  };
  pb::DetectBatchRequest batch;
  expect_field(refuse(batch), grpc::INVALID_ARGUMENT, "frames");
  add_frame(batch, set, 2, {2, 2, 2}, false);
  add_frame(batch, set, 3, {2, 2, 2}, false);
  expect_field(refuse(batch), grpc::INVALID_ARGUMENT, "frames[1].scene_id");
  for (int i = 0; i < 64; ++i) batch.add_frames()->set_scene_id(std::to_string(i));
  expect_field(refuse(batch), grpc::INVALID_ARGUMENT, "frames");
  batch.clear_frames();
  add_frame(batch, set, 2, {2, 2, 2}, false);
  batch.set_max_answer_bytes(~uint64_t{0});
  expect_field(refuse(batch), grpc::RESOURCE_EXHAUSTED, "max_answer_bytes");
  batch.set_max_answer_bytes(1);
  const auto answer = answer_to(batch).answers(0);
  EXPECT_EQ(answer.error().code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_NE(answer.error().message().find("was applied"), std::string::npos) << answer.error().message();
}

TEST_F(Batch, SetsTakeNoFramesOfScenes) {
  const auto set = started_set();
  expect_field(detect(*stub_, set, tip_frame(2, 2)), grpc::FAILED_PRECONDITION, "scene_id");
}

TEST_F(Batch, BadSetsAreNotCreated) {
  const auto refuse = [&](const std::function<void(pb::CreateScenesRequest&)>& change) {
    auto request = tip_set_request(3);
    change(request);
    return create_scenes(*stub_, request);
  };
  expect_field(refuse([](auto& r) { r.set_count(0); }), grpc::INVALID_ARGUMENT, "count");
  expect_field(refuse([](auto& r) { r.set_count(65537); }), grpc::INVALID_ARGUMENT, "count");
  expect_field(refuse([](auto& r) { r.mutable_spec()->mutable_meshes(1)->set_motion(pb::MESH_MOTION_RIGID); }),
               grpc::INVALID_ARGUMENT, "spec.meshes[1].motion");
  expect_field(refuse([](auto& r) { r.mutable_spec()->set_report(pb::REPORT_ANY_HIT); }), grpc::INVALID_ARGUMENT,
               "spec.report");
  expect_field(refuse([](auto& r) { r.mutable_spec()->set_broad_phase_engine(pb::BROAD_PHASE_ENGINE_OCTREE); }),
               grpc::INVALID_ARGUMENT, "spec.broad_phase_engine");
  expect_field(refuse([](auto& r) {
                 r.set_count(65536);
                 r.mutable_spec()->mutable_meshes(0)->set_vertex_count(1 << 20);
               }),
               grpc::RESOURCE_EXHAUSTED, "count");
  EXPECT_TRUE(list_scenes(*stub_).empty());
}

TEST_F(Batch, ARepeatedRequestMakesOneSet) {
  auto request = tip_set_request(3);
  request.set_request_id("again");
  const auto set = make_set(*stub_, request);
  EXPECT_EQ(make_set(*stub_, request), set);
  request.set_count(4);
  EXPECT_EQ(create_scenes(*stub_, request).error_code(), grpc::ALREADY_EXISTS);
}

}  // namespace
}  // namespace collided::test
