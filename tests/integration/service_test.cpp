// The daemon as its clients see it: scenes, frames with known contacts, streams, and its end.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <thread>

#include "tests/integration/daemon_process.hpp"
#include "tests/integration/tip_scene.hpp"

namespace collided::test {
namespace {

class Service : public testing::Test {
 protected:
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

// Two tips in one mesh: vertex 3 meets the floor at t = 1/2, vertex 6 at t = 1/4.
pb::CreateSceneRequest two_tips_request() {
  auto request = tip_request();
  auto* tips = request.mutable_spec()->mutable_meshes(1);
  tips->set_vertex_count(6);
  tips->set_triangles(pack<uint32_t>({0, 1, 2, 3, 4, 5}));
  return request;
}

std::string two_tips(double z0, double z1) {
  Points points = tip_points(z0);
  for (auto point : tip_points(z1)) points.push_back({point[0] + 0.5, point[1], point[2]});
  return pack_points(points, false);
}

pb::Frame two_tips_frame(uint64_t id, pb::Report report) {
  auto frame = id == 1 ? first_frame(2) : tip_frame(id, 2);
  frame.set_report(report);
  frame.mutable_updates(0)->set_start_positions(two_tips(1, 1));
  frame.mutable_updates(0)->set_positions(two_tips(-1, -3));
  return frame;
}

void stream_ten_frames(Stub& stub, bool wide) {
  Stream stream(stub, make_scene(stub, tip_request(wide)));
  ASSERT_TRUE(stream.opened());
  EXPECT_EQ(stream.opened()->window(), 2u);
  for (int i = 0; i < 10; ++i) {
    const double depth = 1.25 + 0.25 * i;
    expect_tip_contact(stream.ask(i == 0 ? first_frame(depth, wide) : tip_frame(i + 1, depth, wide)), depth);
  }
  EXPECT_TRUE(stream.finish().ok());
}

TEST_F(Service, TenFramesInSinglePrecision) { stream_ten_frames(*stub_, false); }
TEST_F(Service, TenFramesInDoublePrecision) { stream_ten_frames(*stub_, true); }

TEST_F(Service, TwoStreamsAtOnce) {
  std::thread other([&] { stream_ten_frames(*stub_, true); });
  stream_ten_frames(*stub_, false);
  other.join();
}

TEST_F(Service, AFrameThatDoesNotReachTheFloorHasNoContact) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  const Answer answer = stream.ask(first_frame(0.5));
  ASSERT_TRUE(answer.done);
  EXPECT_EQ(answer.done->contact_count(), 0u);
  EXPECT_EQ(answer.done->earliest_toi(), 1);
  EXPECT_TRUE(answer.chunks.empty());
}

// Without start positions a mesh moves from where the last frame left it.
TEST_F(Service, FramesContinueTheMotion) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  ASSERT_TRUE(stream.ask(first_frame(0)).done);
  auto frame = tip_frame(2, 2);
  frame.mutable_updates(0)->clear_start_positions();
  expect_tip_contact(stream.ask(frame), 2);
}

TEST_F(Service, DiscreteDetectionFindsACornerWithinTheThickness) {
  auto request = tip_request();
  request.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
  request.mutable_spec()->set_thickness(0.25);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(0.875);  // the tip ends at z = 0.125
  frame.mutable_updates(0)->clear_start_positions();
  const Answer answer = stream.ask(frame);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  ASSERT_EQ(answer.chunks.size(), 1u);
  EXPECT_EQ(answer.chunks[0].elements(), pack<uint32_t>({3, 0}));
  EXPECT_EQ(answer.chunks[0].distance(), pack<double>({0.125}));
  EXPECT_TRUE(answer.chunks[0].toi().empty());
}

// From GUARDED on a thickness of 0 means touching.
TEST_F(Service, DiscreteDetectionFindsACornerThatTouches) {
  auto request = tip_request();
  request.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(1);
  frame.mutable_updates(0)->clear_start_positions();
  const Answer answer = stream.ask(frame);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  ASSERT_EQ(answer.chunks.size(), 1u);
  EXPECT_EQ(answer.chunks[0].elements(), pack<uint32_t>({3, 0}));
}

TEST_F(Service, EveryEngineFindsTheContactAndNamesItself) {
  for (int engine = pb::BroadPhaseEngine_MIN; engine <= pb::BroadPhaseEngine_MAX; ++engine) {
    auto request = tip_request();
    request.mutable_spec()->set_broad_phase_engine(static_cast<pb::BroadPhaseEngine>(engine));
    Stream stream(*stub_, make_scene(*stub_, request));
    ASSERT_TRUE(stream.opened());
    EXPECT_EQ(stream.opened()->scene().spec().broad_phase_engine(), engine);
    const Answer answer = stream.ask(first_frame(2));
    expect_tip_contact(answer, 2);
    EXPECT_NE(answer.done->metrics().broad_phase_engine(), pb::BROAD_PHASE_ENGINE_UNSPECIFIED);
    EXPECT_GE(answer.done->metrics().step_milliseconds(), 0);
    EXPECT_EQ(answer.done->metrics().graph_launches(), 0u);  // CPU cores
  }
}

TEST_F(Service, TrianglesThatCrossAreFound) {
  auto request = tip_request();
  request.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
  request.mutable_spec()->add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(2);  // the tip ends below the floor
  frame.mutable_updates(0)->clear_start_positions();
  const Answer answer = stream.ask(frame);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  EXPECT_TRUE(answer.done->any_contact());
  EXPECT_EQ(answer.done->contact_count(), 1u);
  ASSERT_EQ(answer.chunks.size(), 1u);
  const auto& chunk = answer.chunks[0];
  EXPECT_EQ(chunk.kind(), pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  EXPECT_EQ(chunk.elements(), pack<uint32_t>({0, 1}));
  EXPECT_EQ(chunk.flags().size(), 1u);
  EXPECT_TRUE(chunk.stencils().empty() && chunk.toi().empty() && chunk.distance().empty());
}

TEST_F(Service, AnOverrideHoldsForItsFrameAlone) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  ASSERT_TRUE(stream.ask(first_frame(2)).done);
  auto frame = tip_frame(2, 2);
  frame.set_accuracy(pb::ACCURACY_CANDIDATES);
  const Answer candidates = stream.ask(frame);
  ASSERT_TRUE(candidates.done);
  EXPECT_GT(candidates.done->contact_count(), 1u);  // the edges of the tip that end at its corner, too
  for (const auto& chunk : candidates.chunks) EXPECT_TRUE(chunk.toi().empty() && chunk.flags().empty());
  expect_tip_contact(stream.ask(tip_frame(3, 2)), 2);
}

// A scene at CANDIDATES has what a frame needs that asks for more.
TEST_F(Service, AnOverrideMayAskForMoreThanTheScene) {
  auto request = tip_request();
  request.mutable_spec()->set_accuracy(pb::ACCURACY_CANDIDATES);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(2);
  frame.set_accuracy(pb::ACCURACY_CERTIFIED);
  expect_tip_contact(stream.ask(frame), 2);
  const Answer candidates = stream.ask(tip_frame(2, 2));
  ASSERT_TRUE(candidates.done);
  EXPECT_GT(candidates.done->contact_count(), 1u);
}

TEST_F(Service, ReportsMayBeTheEarliestContactOrOnlyWhetherThereIsOne) {
  Stream stream(*stub_, make_scene(*stub_, two_tips_request()));
  const Answer all = stream.ask(two_tips_frame(1, pb::REPORT_UNSPECIFIED));
  ASSERT_TRUE(all.done);
  EXPECT_EQ(all.done->contact_count(), 2u);
  const Answer earliest = stream.ask(two_tips_frame(2, pb::REPORT_EARLIEST_ONLY));
  ASSERT_TRUE(earliest.done);
  EXPECT_EQ(earliest.done->contact_count(), 1u);
  EXPECT_EQ(earliest.done->earliest_toi(), all.done->earliest_toi());
  ASSERT_EQ(earliest.chunks.size(), 1u);
  EXPECT_EQ(earliest.chunks[0].elements(), pack<uint32_t>({6, 0}));
  EXPECT_EQ(earliest.chunks[0].toi(), pack<double>({all.done->earliest_toi()}));
  const Answer any_hit = stream.ask(two_tips_frame(3, pb::REPORT_ANY_HIT));
  ASSERT_TRUE(any_hit.done);
  EXPECT_TRUE(any_hit.done->any_contact());
  EXPECT_EQ(any_hit.done->contact_count(), 0u);
  EXPECT_EQ(any_hit.done->earliest_toi(), 1);
  EXPECT_TRUE(any_hit.chunks.empty());
  EXPECT_EQ(stream.ask(two_tips_frame(4, pb::REPORT_UNSPECIFIED)).done->contact_count(), 2u);
}

TEST_F(Service, AFrameWithoutContactHasNoHit) {
  auto request = tip_request();
  request.mutable_spec()->set_report(pb::REPORT_ANY_HIT);
  Stream stream(*stub_, make_scene(*stub_, request));
  const Answer answer = stream.ask(first_frame(0.5));
  ASSERT_TRUE(answer.done);
  EXPECT_FALSE(answer.done->any_contact());
}

// Floats at 1e8 are 8 apart, as much as the triangles are large.
TEST_F(Service, CoarsePositionsAreWarnedOf) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  auto far = first_frame(2);
  for (auto& update : *far.mutable_updates()) {
    Points points = update.mesh() == 0 ? floor_points() : tip_points(-1);
    for (auto& point : points) point[0] += 1e8;
    update.clear_start_positions();
    update.set_positions(pack_points(points, false));
  }
  const Answer answer = stream.ask(far);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  ASSERT_EQ(answer.done->metrics().warnings_size(), 1);
  EXPECT_EQ(answer.done->metrics().warnings(0), pb::FRAME_WARNING_INPUT_RESOLUTION);
}

TEST_F(Service, ADeltaFinerThanThePositionsIsWarnedOfInItsFrameAlone) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  auto frame = first_frame(2);
  frame.set_delta(1e-12);
  EXPECT_EQ(stream.ask(frame).done->metrics().warnings_size(), 1);
  EXPECT_EQ(stream.ask(tip_frame(2, 2)).done->metrics().warnings_size(), 0);
}

TEST_F(Service, FramesInFlightAreAnsweredInOrder) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()), 16);
  stream.send(first_frame(2));
  for (uint64_t id = 2; id <= 16; ++id) stream.send(tip_frame(id, 1 + 0.5 * id));
  expect_tip_contact(stream.receive(1), 2);
  for (uint64_t id = 2; id <= 16; ++id) expect_tip_contact(stream.receive(id), 1 + 0.5 * id);
}

// A client that sends more than its credits is held back, not harmed.
TEST_F(Service, MoreFramesThanCredits) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()), 1);
  stream.send(first_frame(2));
  for (uint64_t id = 2; id <= 50; ++id) stream.send(tip_frame(id, 2));
  for (uint64_t id = 1; id <= 50; ++id) expect_tip_contact(stream.receive(id), 2);
}

TEST_F(Service, DetectFrameAnswersInOneMessage) {
  pb::DetectFrameRequest request;
  request.set_scene_id(make_scene(*stub_, tip_request()));
  *request.mutable_frame() = first_frame(2);
  grpc::ClientContext context;
  pb::DetectFrameResponse response;
  const auto status = stub_->DetectFrame(&context, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  expect_tip_contact({response.contacts().begin(), response.contacts().end()}, response.done(), 2);
  EXPECT_GT(response.done().metrics().stages_size(), 0);
  EXPECT_EQ(response.done().metrics().bytes_in(), 9u * 12);
  EXPECT_EQ(response.done().metrics().bytes_out(), 41u);
}

TEST_F(Service, UploadedTrianglesMakeTheSceneReady) {
  auto request = tip_request();
  request.mutable_spec()->mutable_meshes(0)->clear_triangles();
  request.mutable_spec()->mutable_meshes(0)->set_triangle_count(1);
  const auto id = make_scene(*stub_, request);
  EXPECT_FALSE(Stream(*stub_, id).opened());
  grpc::ClientContext context;
  pb::UploadMeshResponse response;
  auto upload = stub_->UploadMesh(&context, &response);
  pb::UploadMeshRequest chunk;
  chunk.set_scene_id(id);
  chunk.set_triangles(pack<uint32_t>({0, 1, 2}));
  upload->Write(chunk);
  upload->WritesDone();
  const auto status = upload->Finish();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.scene().state(), pb::SCENE_STATE_READY);
  Stream stream(*stub_, id);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST_F(Service, ScenesAreListedInPagesAndDeleted) {
  for (int i = 0; i < 5; ++i) make_scene(*stub_, tip_request());
  std::vector<std::string> ids;
  pb::ListScenesRequest request;
  request.set_page_size(2);
  do {
    grpc::ClientContext context;
    pb::ListScenesResponse response;
    ASSERT_TRUE(stub_->ListScenes(&context, request, &response).ok());
    EXPECT_LE(response.scenes_size(), 2);
    for (const auto& scene : response.scenes()) ids.push_back(scene.scene_id());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  ASSERT_EQ(ids.size(), 5u);
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
  Stream stream(*stub_, ids[0]);
  pb::DeleteSceneRequest gone;
  gone.set_scene_id(ids[0]);
  pb::DeleteSceneResponse deleted;
  grpc::ClientContext first, second;
  EXPECT_TRUE(stub_->DeleteScene(&first, gone, &deleted).ok());
  EXPECT_EQ(stub_->DeleteScene(&second, gone, &deleted).error_code(), grpc::NOT_FOUND);
  EXPECT_TRUE(stream.ask(first_frame(2)).ended);
  EXPECT_EQ(stream.finish().error_code(), grpc::NOT_FOUND);
}

TEST_F(Service, GetSceneShowsWhatItHolds) {
  const auto id = make_scene(*stub_, tip_request());
  Stream stream(*stub_, id);
  ASSERT_TRUE(stream.ask(first_frame(2)).done);
  pb::GetSceneRequest request;
  request.set_scene_id(id);
  grpc::ClientContext context;
  pb::GetSceneResponse response;
  ASSERT_TRUE(stub_->GetScene(&context, request, &response).ok());
  const auto& scene = response.scene();
  EXPECT_EQ(scene.state(), pb::SCENE_STATE_READY);
  EXPECT_EQ(scene.vertex_count(), 6u);
  EXPECT_EQ(scene.edge_count(), 6u);
  EXPECT_EQ(scene.triangle_count(), 2u);
  EXPECT_EQ(scene.last_frame_id(), 1u);
  EXPECT_EQ(scene.spec().accuracy(), pb::ACCURACY_CERTIFIED);
  EXPECT_EQ(scene.spec().report(), pb::REPORT_ALL);
  EXPECT_GT(scene.memory_size(), 0);
}

TEST_F(Service, ServerInfoNamesVersionAndDevices) {
  grpc::ClientContext context;
  pb::GetServerInfoResponse response;
  ASSERT_TRUE(stub_->GetServerInfo(&context, {}, &response).ok());
  EXPECT_EQ(response.version(), COLLIDED_VERSION);
  ASSERT_GT(response.devices_size(), 0);
  EXPECT_EQ(response.devices(0).backend(), pb::BACKEND_CPU);
  EXPECT_EQ(response.limits().max_message_bytes(), 64u << 20);
}

TEST_F(Service, AClientThatGivesUpLeavesTheSceneUnharmed) {
  const auto id = make_scene(*stub_, tip_request());
  {
    Stream stream(*stub_, id);
    ASSERT_TRUE(stream.ask(first_frame(2)).done);
    stream.send(tip_frame(2, 2));
    stream.cancel();
    EXPECT_EQ(stream.finish().error_code(), grpc::CANCELLED);
  }
  Stream stream(*stub_, id);
  ASSERT_TRUE(stream.opened());
  expect_tip_contact(stream.ask(tip_frame(3, 3)), 3);
}

TEST_F(Service, TerminationIsClean) {
  make_scene(*stub_, tip_request());
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(daemon_.stop(), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(4));  // an idle client costs no grace
}

TEST_F(Service, AnOpenStreamIsToldOfTheStopAndMayFinish) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  ASSERT_TRUE(stream.ask(first_frame(2)).done);
  daemon_.signal(SIGTERM);
  pb::StreamFramesResponse response;
  ASSERT_TRUE(stream.read(&response));
  EXPECT_EQ(response.draining().deadline_seconds(), 5);
  grpc::ClientContext context;
  pb::CreateSceneResponse refused;
  EXPECT_EQ(stub_->CreateScene(&context, tip_request(), &refused).error_code(), grpc::UNAVAILABLE);
  expect_tip_contact(stream.ask(tip_frame(2, 3)), 3);
  EXPECT_TRUE(stream.finish().ok());
  EXPECT_EQ(daemon_.wait(), 0);
}

TEST_F(Service, AStreamThatHasNotOpenedEndsWithTheStop) {
  grpc::ClientContext context;
  auto call = stub_->StreamFrames(&context);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  daemon_.signal(SIGTERM);
  pb::StreamFramesResponse response;
  EXPECT_FALSE(call->Read(&response));
  EXPECT_EQ(call->Finish().error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(daemon_.wait(), 0);
}

TEST(Lifecycle, AStreamThatStaysIsEndedAfterTheGrace) {
  DaemonProcess daemon({"--grace-seconds", "0.2"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  Stream stream(*stub, make_scene(*stub, tip_request()));
  daemon.signal(SIGINT);
  EXPECT_EQ(daemon.wait(), 0);
}

TEST(Lifecycle, ASecondDaemonDoesNotTakeASocketOver) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto id = make_scene(*stub, tip_request());
  FILE* second =
      popen(("timeout 20 " COLLIDED_DAEMON " --backend cpu --address " + daemon.address() + " 2>&1").c_str(), "r");
  ASSERT_NE(second, nullptr);
  std::string text;
  for (std::array<char, 256> line; std::fgets(line.data(), line.size(), second);) text += line.data();
  EXPECT_EQ(WEXITSTATUS(pclose(second)), 1);
  EXPECT_NE(text.find("another daemon serves there"), std::string::npos) << text;
  auto again = pb::CollisionService::NewStub(daemon.channel());
  EXPECT_TRUE(Stream(*again, id).opened());
}

TEST(Lifecycle, ASocketThatADeadDaemonLeftIsTakenOver) {
  DaemonProcess daemon;
  daemon.signal(SIGKILL);
  daemon.wait();
  DaemonProcess next({"--address", daemon.address()});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  make_scene(*stub, tip_request());
}

}  // namespace
}  // namespace collided::test
