#pragma once
// Unary calls, each with a deadline, and the details of refusals.

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "collided/v1/collision_service.grpc.pb.h"
#include "collided/v1/error_details.pb.h"

namespace collided::test {

namespace pb = collided::v1;
using Stub = pb::CollisionService::Stub;

/// No call of a test takes this long; one that does ends with DEADLINE_EXCEEDED.
constexpr std::chrono::milliseconds kNoCallTakesLonger = std::chrono::seconds(60);

inline void set_deadline(grpc::ClientContext& context, std::chrono::milliseconds most = kNoCallTakesLonger) {
  context.set_deadline(std::chrono::system_clock::now() + most);
}

/// Channels to the same address share a connection, unless their `number`s differ.
inline std::shared_ptr<grpc::Channel> channel_to(const std::string& address, int number = 0) {
  grpc::ChannelArguments arguments;
  arguments.SetInt("collided.test.connection", number);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

inline grpc::Status create_scene(Stub& stub, const pb::CreateSceneRequest& request, pb::Scene* scene = nullptr) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::CreateSceneResponse response;
  const auto status = stub.CreateScene(&context, request, &response);
  if (scene) *scene = response.scene();
  return status;
}

/// A scene whose creation must succeed.
inline pb::Scene made_scene(Stub& stub, const pb::CreateSceneRequest& request) {
  pb::Scene scene;
  const auto status = create_scene(stub, request, &scene);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return scene;
}

inline std::string make_scene(Stub& stub, const pb::CreateSceneRequest& request) {
  return made_scene(stub, request).scene_id();
}

inline grpc::Status get_scene(Stub& stub, const std::string& id, pb::Scene* scene = nullptr) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::GetSceneRequest request;
  request.set_scene_id(id);
  pb::GetSceneResponse response;
  const auto status = stub.GetScene(&context, request, &response);
  if (scene) *scene = response.scene();
  return status;
}

/// The first page.
inline std::vector<pb::Scene> list_scenes(Stub& stub) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::ListScenesResponse response;
  const auto status = stub.ListScenes(&context, {}, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return {response.scenes().begin(), response.scenes().end()};
}

inline grpc::Status delete_scene(Stub& stub, const std::string& id) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::DeleteSceneRequest request;
  request.set_scene_id(id);
  pb::DeleteSceneResponse response;
  return stub.DeleteScene(&context, request, &response);
}

inline grpc::Status detect(Stub& stub, const std::string& id, const pb::Frame& frame,
                           pb::DetectFrameResponse* response = nullptr,
                           std::chrono::milliseconds most = kNoCallTakesLonger) {
  grpc::ClientContext context;
  set_deadline(context, most);
  pb::DetectFrameRequest request;
  request.set_scene_id(id);
  *request.mutable_frame() = frame;
  pb::DetectFrameResponse unread;
  return stub.DetectFrame(&context, request, response ? response : &unread);
}

/// The details of a refusal besides its message.
struct Details {
  std::vector<std::string> fields;    ///< of google.rpc.BadRequest
  std::vector<std::string> subjects;  ///< of google.rpc.QuotaFailure
};

/// Parses metadata `grpc-status-details-bin`; it must repeat the code and the message of the status.
inline Details details_of(const grpc::Status& status) {
  pb::RpcStatus parsed;
  EXPECT_TRUE(parsed.ParseFromString(status.error_details()));
  EXPECT_EQ(parsed.code(), status.error_code());
  EXPECT_EQ(parsed.message(), status.error_message());
  Details details;
  for (const auto& detail : parsed.details()) {
    pb::BadRequest request;
    if (detail.type_url() == "type.googleapis.com/google.rpc.BadRequest" && request.ParseFromString(detail.value()))
      for (const auto& violation : request.field_violations()) details.fields.push_back(violation.field());
    pb::QuotaFailure quota;
    if (detail.type_url() == "type.googleapis.com/google.rpc.QuotaFailure" && quota.ParseFromString(detail.value()))
      for (const auto& violation : quota.violations()) details.subjects.push_back(violation.subject());
  }
  return details;
}

/// A refusal of a field, with all its details.
inline void expect_field(const grpc::Status& status, grpc::StatusCode code, const std::string& field) {
  EXPECT_EQ(status.error_code(), code) << status.error_message();
  EXPECT_NE(status.error_message().find(field), std::string::npos) << status.error_message();
  EXPECT_EQ(details_of(status).fields, std::vector<std::string>{field}) << status.error_message();
}

/// A refusal because of a limit that the message names.
inline void expect_quota(const grpc::Status& status, const std::string& limit, const std::string& subject) {
  EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
  EXPECT_NE(status.error_message().find(limit), std::string::npos) << status.error_message();
  const auto subjects = details_of(status).subjects;
  ASSERT_EQ(subjects.size(), 1u) << status.error_message();
  EXPECT_TRUE(subjects[0].starts_with(subject)) << subjects[0];
}

}  // namespace collided::test
