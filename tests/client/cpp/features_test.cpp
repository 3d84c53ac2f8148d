// What a daemon that is older than the library lacks: the library's protocol, with additions of release 99.0.0.

#include "client/cpp/transport/features.hpp"

#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/text_format.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <set>

#include "client/cpp/client.hpp"
#include "client/cpp/transport/grpc/grpc_transport.hpp"
#include "collided/v1/added_in.pb.h"

namespace collided::client {
namespace {

using namespace google::protobuf;

constexpr auto kService = "collided/v1/collision_service.proto", kScene = "collided/v1/scene.proto";
constexpr auto kRelease = "99.0.0";
constexpr int kNumber = 99;

/// Adds `file` and what it imports to `pool`, changed by `change`.
template <class Change>
void copy_into(DescriptorPool& pool, const FileDescriptor& file, const Change& change) {
  if (pool.FindFileByName(std::string(file.name()))) return;
  for (int i = 0; i < file.dependency_count(); ++i) copy_into(pool, *file.dependency(i), change);
  FileDescriptorProto copy;
  file.CopyTo(&copy);
  change(copy);
  ASSERT_TRUE(pool.BuildFile(copy)) << file.name();
}

template <class Entries>
auto& named(Entries& entries, const std::string& name) {
  for (auto& entry : entries)
    if (entry.name() == name) return entry;
  throw std::out_of_range(name);
}

void add_field(FileDescriptorProto& file, const std::string& message, const std::string& name) {
  FieldDescriptorProto& field = *named(*file.mutable_message_type(), message).add_field();
  field.set_name(name);
  field.set_number(kNumber);
  field.set_type(FieldDescriptorProto::TYPE_BOOL);
  field.set_label(FieldDescriptorProto::LABEL_OPTIONAL);
  field.mutable_options()->SetExtension(v1::field_added_in, kRelease);
}

/// The protocol with two fields, a value and a method more.
void make_newer(FileDescriptorProto& file) {
  if (file.name() == kScene) {
    add_field(file, "SceneSpec", "mirrored");
    add_field(file, "MeshSpec", "layered");
    auto& value = *named(*file.mutable_enum_type(), "Report").add_value();
    value.set_name("REPORT_DEEPEST");
    value.set_number(kNumber);
    value.mutable_options()->SetExtension(v1::value_added_in, kRelease);
  }
  if (file.name() != kService) return;
  auto& method = named(*file.mutable_service(0)->mutable_method(), "EstimateScene");
  method.mutable_options()->SetExtension(v1::method_added_in, kRelease);
}

class NewerLibrary : public testing::Test {
 protected:
  NewerLibrary() { copy_into(pool, *v1::GetServerInfoResponse::descriptor()->file(), make_newer); }

  v1::Additions additions() const { return v1::additions_of(*pool.FindFileByName(kService)); }

  /// A request of the newer protocol, as text.
  std::unique_ptr<Message> request(const std::string& name, const std::string& text) {
    const Descriptor* type = pool.FindMessageTypeByName("collided.v1." + name);
    std::unique_ptr<Message> message(factory.GetPrototype(type)->New());
    EXPECT_TRUE(TextFormat::ParseFromString(text, message.get())) << text;
    return message;
  }

  static v1::GetServerInfoResponse daemon(const std::set<std::string>& features = {}) {
    v1::GetServerInfoResponse info;
    info.set_version("0.1.0");
    for (const std::string& feature : features) info.add_features(feature);
    return info;
  }

  /// What is refused, or nothing.
  std::string refused(const std::string& name, const std::string& text, const std::set<std::string>& known = {}) {
    try {
      Features(daemon(known), "here", additions()).check_call(*request(name, text));
      return "";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), grpc::UNIMPLEMENTED);
      EXPECT_EQ(e.message(), e.field() + " needs a daemon of release 99.0.0 or later; the daemon at here is 0.1.0");
      return e.field();
    }
  }

  DescriptorPool pool;
  DynamicMessageFactory factory;
};

TEST_F(NewerLibrary, KnowsItsAdditions) {
  const v1::Additions found = additions();
  for (const char* name :
       {"SceneSpec.mirrored", "MeshSpec.layered", "REPORT_DEEPEST", "CollisionService.EstimateScene"})
    EXPECT_EQ(found.at(std::string("collided.v1.") + name), kRelease) << name;
  EXPECT_EQ(found.size(), v1::additions_of(*v1::GetServerInfoResponse::descriptor()->file()).size() + 4);
}

TEST_F(NewerLibrary, RefusesWhatAnOlderDaemonWouldIgnore) {
  EXPECT_EQ(refused("CreateSceneRequest", "spec { mirrored: true }"), "spec.mirrored");
  EXPECT_EQ(refused("CreateSceneRequest", "spec { meshes {} meshes { layered: true } }"), "spec.meshes[1].layered");
  EXPECT_EQ(refused("CreateSceneRequest", "spec { report: REPORT_DEEPEST }"), "spec.report = REPORT_DEEPEST");
  EXPECT_EQ(refused("EstimateSceneRequest", ""), "EstimateScene");
}

TEST_F(NewerLibrary, AsksForTheRest) {
  EXPECT_EQ(refused("CreateSceneRequest", "spec { meshes { name: 'a' } report: REPORT_ALL kinds: [1, 2] }"), "");
  EXPECT_EQ(refused("CreateSceneRequest", "spec { mirrored: true }", {"collided.v1.SceneSpec.mirrored"}), "");
  EXPECT_EQ(refused("EstimateSceneRequest", "", {"collided.v1.CollisionService.EstimateScene"}), "");
}

TEST_F(NewerLibrary, RefusesAnAdvanceModeThatAnOlderDaemonWouldIgnore) {
  const Features older(daemon(), "here"),
      newer(daemon({"collided.v1.Frame.advance_mode", "collided.v1.ADVANCE_MODE_PER_MESH"}), "here");
  v1::Frame frame;
  frame.set_advance(true);
  EXPECT_NO_THROW(older.check(frame, "frame"));
  frame.set_advance_mode(v1::ADVANCE_MODE_PER_MESH);
  EXPECT_NO_THROW(newer.check(frame, "frame"));
  try {
    older.check(frame, "frame");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), grpc::UNIMPLEMENTED);
    EXPECT_EQ(e.message(), "frame.advance_mode needs a daemon of release 0.2.0 or later; the daemon at here is 0.1.0");
  }
}

TEST_F(NewerLibrary, NamesWhatAnOlderDaemonLacks) {
  const std::string field = "collided.v1.CONTACT_FIELD_FEATURES";
  EXPECT_TRUE(Features(daemon(), "here").lack(field));
  EXPECT_FALSE(Features(daemon({field}), "here").lack(field));
  EXPECT_FALSE(Features(daemon(), "here").lack("collided.v1.CONTACT_FIELD_FLAGS"));
}

TEST_F(NewerLibrary, RefusesAnOpeningBeforeAnythingIsSent) {
  v1::OpenStream open;
  open.set_window(2);
  const auto lacking =
      std::make_shared<Features>(daemon(), "here", v1::Additions{{"collided.v1.OpenStream.window", kRelease}});
  auto nowhere = std::make_unique<GrpcTransport>(
      grpc::CreateChannel("unix:/nonexistent/socket", grpc::InsecureChannelCredentials()),
      std::make_unique<grpc::ClientContext>(), 1 << 20);
  try {
    FrameStream::open(std::move(nowhere), open, {.features = lacking});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.field(), "open.window");
  }
}

}  // namespace
}  // namespace collided::client
