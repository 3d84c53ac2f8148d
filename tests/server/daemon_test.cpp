// A whole daemon in this process: the same facts of scenes in every answer, the contents of its log lines, and changes
// while it runs.
#include "server/daemon.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "server/ops/log.hpp"
#include "tests/server/config/parse.hpp"
#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

using Json = nlohmann::json;

class WholeDaemon : public testing::Test {
 protected:
  WholeDaemon() {
    config_ = Serving::cpu_config();
    config_.addresses = {"unix:" + folder_.file("socket")};
    config_.local_socket = folder_.file("local");
  }
  void start() {
    daemon_.emplace(config_, lifecycle_);
    stub_ = pb::CollisionService::NewStub(test::channel_to(config_.addresses[0]));
  }
  // Log lines of a daemon that runs while the body does.
  template <class Body>
  std::vector<Json> lines_of(const Body& body) {
    set_up_log("json", "debug");
    testing::internal::CaptureStderr();
    start();
    body();
    daemon_.reset();
    std::istringstream text(testing::internal::GetCapturedStderr());
    set_up_log("text", "off");
    std::vector<Json> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(Json::parse(line));
    return lines;
  }

  Folder folder_;
  Config config_;
  Lifecycle lifecycle_;
  std::optional<Daemon> daemon_;
  std::unique_ptr<test::Stub> stub_;
};

pb::Scene upload_tip(test::Stub& stub, const std::string& scene_id) {
  grpc::ClientContext context;
  test::set_deadline(context);
  pb::UploadMeshResponse response;
  const auto writer = stub.UploadMesh(&context, &response);
  pb::UploadMeshRequest chunk;
  chunk.set_scene_id(scene_id);
  chunk.set_mesh(1);
  chunk.set_triangles(test::pack<uint32_t>({0, 1, 2}));
  writer->Write(chunk);
  writer->WritesDone();
  EXPECT_TRUE(writer->Finish().ok());
  return response.scene();
}

TEST_F(WholeDaemon, IdsOfScenesBeginWithItsName) {
  config_.name = "gpu-3";
  start();
  const std::string id = test::made_scene(*stub_, test::tip_request()).scene_id();
  EXPECT_TRUE(id.starts_with("gpu-3."));
  EXPECT_EQ(id.size(), std::string("gpu-3.").size() + 32);
}

TEST_F(WholeDaemon, EveryAnswerWithASceneTellsItsEndpoint) {
  config_.endpoint = "sim.example:50551";
  start();
  auto request = test::tip_request();
  request.mutable_spec()->mutable_meshes(1)->clear_triangles();
  request.mutable_spec()->mutable_meshes(1)->set_triangle_count(1);
  const pb::Scene made = test::made_scene(*stub_, request);
  std::vector<pb::Scene> told = {made, upload_tip(*stub_, made.scene_id()), {}};
  EXPECT_TRUE(test::get_scene(*stub_, made.scene_id(), &told.back()).ok());
  told.push_back(test::list_scenes(*stub_).at(0));
  {
    const test::Stream stream(*stub_, made.scene_id());
    ASSERT_TRUE(stream.opened());
    told.push_back(stream.opened()->scene());
  }
  auto local_opening = test::open_request(made.scene_id(), 0, 0);
  local_opening.mutable_open()->mutable_open()->set_resume_token(made.resume_token());
  const RawLocal local(config_.local_socket);
  local.send(local_opening);
  const auto opened = local.receive();
  ASSERT_TRUE(opened && opened->frame().has_opened());
  told.push_back(opened->frame().opened().scene());
  for (const auto& scene : told) {
    EXPECT_EQ(scene.scene_id(), made.scene_id());
    EXPECT_EQ(scene.endpoint(), config_.endpoint);
  }
}

size_t count_of(const std::vector<Json>& lines, const std::string& message) {
  return static_cast<size_t>(
      std::count_if(lines.begin(), lines.end(), [&](const Json& line) { return line["message"] == message; }));
}

void expect_fields(const std::vector<Json>& lines, const std::vector<std::string>& messages, const std::string& field,
                   const std::string& value) {
  for (const auto& message : messages) EXPECT_GT(count_of(lines, message), 0u) << message;
  for (const auto& line : lines) {
    const bool is_one =
        std::find(messages.begin(), messages.end(), line["message"].get<std::string>()) != messages.end();
    if (!is_one) continue;
    EXPECT_EQ(line.value(field, ""), value) << line;
  }
}

TEST_F(WholeDaemon, EveryLineOfAStreamCarriesItsRequest) {
  const auto lines = lines_of([&] {
    const std::string scene = test::make_scene(*stub_, test::tip_request());
    grpc::ClientContext context;
    test::set_deadline(context);
    context.AddMetadata("x-request-id", "r-1");
    const auto call = stub_->StreamFrames(&context);
    call->Write(test::Stream::opening(scene));
    pb::StreamFramesResponse response;
    EXPECT_TRUE(call->Read(&response));
    pb::StreamFramesRequest frame;
    for (int i = 0; i < 2; ++i) {  // the second one is stale
      *frame.mutable_frame() = test::first_frame(2);
      call->Write(frame);
    }
    call->WritesDone();
    while (call->Read(&response)) continue;
    EXPECT_TRUE(call->Finish().ok());
  });
  expect_fields(lines, {"stream opened", "frame answered", "frame refused", "stream ends"}, "request", "r-1");
}

TEST_F(WholeDaemon, AStreamThatIsNotLetInHasItsRequest) {
  const TextFile tokens("[[tokens]]\nname = \"one\"\ntoken = \"0123456789abcdef\"\n");
  config_.tokens_file = tokens.path();
  const auto lines = lines_of([&] {
    grpc::ClientContext context;
    test::set_deadline(context);
    context.AddMetadata("x-request-id", "r-2");
    const auto call = stub_->StreamFrames(&context);
    EXPECT_EQ(call->Finish().error_code(), grpc::UNAUTHENTICATED);
  });
  expect_fields(lines, {"stream ends"}, "request", "r-2");
}

TEST_F(WholeDaemon, TheLinesOfALocalStreamCarryItsSceneAndOneRequest) {
  std::string scene;
  const auto lines = lines_of([&] {
    scene = test::make_scene(*stub_, test::tip_request());
    LocalStream stream(config_.local_socket, scene);
    EXPECT_TRUE(stream.ask_shared(test::first_frame(2)).done);
    EXPECT_TRUE(stream.ask_shared(test::first_frame(2)).error);
    stream.raw().half_close();
    EXPECT_EQ(stream.raw().closed().code(), 0);
  });
  const std::vector<std::string> messages = {"local stream opened", "frame answered", "frame refused",
                                             "local stream ends"};
  expect_fields(lines, messages, "scene", scene);
  const auto opened =
      std::find_if(lines.begin(), lines.end(), [&](const Json& line) { return line["message"] == messages[0]; });
  ASSERT_NE(opened, lines.end());
  ASSERT_FALSE(opened->value("request", "").empty());
  expect_fields(lines, messages, "request", opened->value("request", ""));
}

TEST_F(WholeDaemon, ALocalStreamThatIsRefusedHasTheSceneThatItAskedFor) {
  std::string scene;
  const auto lines = lines_of([&] {
    scene = test::make_scene(*stub_, test::tip_request());
    const RawLocal raw(config_.local_socket);
    raw.send(test::open_request(scene, 0, 0, 1000));
    EXPECT_EQ(raw.closed().field(), "open.window");
  });
  expect_fields(lines, {"local stream ends"}, "scene", scene);
}

TEST(LocalLines, OfASkippedFrameCarryTheRequest) {
  set_up_log("json", "debug");
  testing::internal::CaptureStderr();
  {
    Serving serving;
    const std::string scene = serving.make_scene();
    auto opening = test::open_request(scene, 0, 0, 3);
    opening.mutable_open()->mutable_open()->set_delivery(pb::DELIVERY_POLICY_LATEST_WINS);
    const RawLocal raw(serving.path());
    raw.send(opening);
    EXPECT_TRUE(raw.receive());
    std::promise<void> free;
    serving.scene(scene)->worker().post([&] { free.get_future().wait(); });
    auto whole = test::first_frame(2);
    for (uint64_t id = 1; id <= 3; ++id) {
      whole.set_frame_id(id);
      raw.send(whole);
    }
    EXPECT_TRUE(eventually([&] { return serving.scene(scene)->record().stream()->waiting() == 3; }));
    free.set_value();
    raw.half_close();
    EXPECT_EQ(raw.closed().code(), 0);
  }
  flush_log();
  const std::string text = testing::internal::GetCapturedStderr();
  set_up_log("text", "off");
  std::istringstream lines(text);
  int skipped = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto json = Json::parse(line);
    if (json["message"] != "frame skipped") continue;
    ++skipped;
    EXPECT_FALSE(json.value("request", "").empty()) << line;
  }
  EXPECT_EQ(skipped, 2) << text;
}

TEST(Reloading, TheWindowHoldsForUnaryFramesOfScenesThatAreThere) {
  Serving serving;
  Limits limits = serving.host().limits();
  limits.max_window = 1;
  serving.host().set_limits(limits);
  const std::string id = serving.make_scene();
  SceneWorker& worker = serving.scene(id)->worker();
  std::promise<void> begun, free;
  worker.post([&] {
    begun.set_value();
    free.get_future().wait();
  });
  begun.get_future().wait();
  EXPECT_TRUE(worker.try_post([] {}));
  EXPECT_FALSE(worker.try_post([] {}));
  limits.max_window = 2;
  serving.host().set_limits(limits);
  EXPECT_TRUE(worker.try_post([] {}));
  EXPECT_FALSE(worker.try_post([] {}));
  free.set_value();
  worker.flush();
}

}  // namespace
}  // namespace collided::server
