#pragma once
// A scene whose contacts are known: the lowest corner of a triangle ("tip") falls from z = 1 to 1 - depth through the
// inside of a triangle in z = 0 ("floor"). For depth > 1 there is one contact, vertex 3 with triangle 0, at 1 / depth.

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collided/v1/collision_service.grpc.pb.h"

namespace collided::test {

namespace pb = collided::v1;
using Stub = pb::CollisionService::Stub;
using Points = std::vector<std::array<double, 3>>;

template <class T>
std::string pack(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

inline std::string pack_points(const Points& points, bool wide) {
  std::vector<double> doubles;
  for (const auto& point : points) doubles.insert(doubles.end(), point.begin(), point.end());
  return wide ? pack(doubles) : pack(std::vector<float>(doubles.begin(), doubles.end()));
}

inline Points floor_points() { return {{-2, -2, 0}, {2, -2, 0}, {0, 2, 0}}; }
// The two upper corners stay far above the floor, so that no edge of the tip meets an edge of the floor.
inline Points tip_points(double z) { return {{0, 0, z}, {-0.1, 0, 9}, {0.1, 0, 9}}; }

inline pb::CreateSceneRequest tip_request(bool wide = false) {
  pb::CreateSceneRequest request;
  auto* spec = request.mutable_spec();
  spec->set_display_name("tip");
  spec->set_mode(pb::DETECTION_MODE_CCD);
  spec->set_position_format(wide ? pb::POSITION_FORMAT_F64 : pb::POSITION_FORMAT_F32);
  for (const char* name : {"floor", "tip"}) {
    auto* mesh = spec->add_meshes();
    mesh->set_name(name);
    mesh->set_vertex_count(3);
    mesh->set_triangles(pack<uint32_t>({0, 1, 2}));
  }
  spec->mutable_meshes(0)->set_motion(pb::MESH_MOTION_STATIC);
  return request;
}

inline pb::Frame tip_frame(uint64_t id, double depth, bool wide = false) {
  pb::Frame frame;
  frame.set_frame_id(id);
  auto* tip = frame.add_updates();
  tip->set_mesh(1);
  tip->set_start_positions(pack_points(tip_points(1), wide));
  tip->set_positions(pack_points(tip_points(1 - depth), wide));
  return frame;
}

/// The first frame also brings the floor.
inline pb::Frame first_frame(double depth, bool wide = false) {
  pb::Frame frame = tip_frame(1, depth, wide);
  auto* floor = frame.add_updates();
  floor->set_mesh(0);
  floor->set_positions(pack_points(floor_points(), wide));
  return frame;
}

inline std::string make_scene(Stub& stub, const pb::CreateSceneRequest& request) {
  grpc::ClientContext context;
  pb::CreateSceneResponse response;
  const auto status = stub.CreateScene(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response.scene().scene_id();
}

/// What came for one frame.
struct Answer {
  std::vector<pb::ContactChunk> chunks;
  std::optional<pb::FrameDone> done;
  std::optional<pb::FrameError> error;
  bool ended = false;  ///< the stream ended instead
};

inline void expect_tip_contact(const std::vector<pb::ContactChunk>& chunks, const pb::FrameDone& done, double depth) {
  EXPECT_EQ(done.contact_count(), 1u);
  ASSERT_EQ(chunks.size(), 1u);
  const auto& chunk = chunks[0];
  EXPECT_EQ(chunk.kind(), pb::CONTACT_KIND_VERTEX_TRIANGLE);
  EXPECT_EQ(chunk.count(), 1u);
  EXPECT_EQ(chunk.elements(), pack<uint32_t>({3, 0}));
  EXPECT_EQ(chunk.stencils(), pack<uint32_t>({3, 0, 1, 2}));
  ASSERT_EQ(chunk.toi().size(), sizeof(double));
  double toi = 0;
  std::memcpy(&toi, chunk.toi().data(), sizeof(toi));
  EXPECT_LE(toi, 1 / depth);
  EXPECT_GT(toi, 1 / depth - 1e-3);
  EXPECT_TRUE(done.any_contact());
  EXPECT_EQ(done.earliest_toi(), toi);
  EXPECT_EQ(chunk.flags().size(), 1u);
}

inline void expect_tip_contact(const Answer& answer, double depth) {
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "the stream ended");
  expect_tip_contact(answer.chunks, *answer.done, depth);
}

/// A StreamFrames call.
class Stream {
 public:
  Stream(Stub& stub, const std::string& scene_id, uint32_t window = 0) : call_(stub.StreamFrames(&context_)) {
    pb::StreamFramesRequest request;
    request.mutable_open()->set_scene_id(scene_id);
    request.mutable_open()->set_window(window);
    open(request);
  }
  Stream(Stub& stub, const pb::StreamFramesRequest& request) : call_(stub.StreamFrames(&context_)) { open(request); }
  ~Stream() {
    if (!call_) return;
    context_.TryCancel();
    finish();
  }

  const std::optional<pb::StreamOpened>& opened() const { return opened_; }
  void send(const pb::Frame& frame) {
    pb::StreamFramesRequest request;
    *request.mutable_frame() = frame;
    call_->Write(request);
  }
  Answer receive(uint64_t frame_id) {
    Answer answer;
    pb::StreamFramesResponse response;
    while (call_->Read(&response)) {
      EXPECT_EQ(response.frame_id(), frame_id);
      if (response.has_contacts()) answer.chunks.push_back(response.contacts());
      if (response.has_done()) answer.done = response.done();
      if (response.has_error()) answer.error = response.error();
      if (response.has_done() || response.has_error()) return answer;
    }
    answer.ended = true;
    return answer;
  }
  Answer ask(const pb::Frame& frame) {
    send(frame);
    return receive(frame.frame_id());
  }
  bool read(pb::StreamFramesResponse* response) { return call_->Read(response); }
  void cancel() { context_.TryCancel(); }
  grpc::Status finish() {
    call_->WritesDone();
    pb::StreamFramesResponse response;
    while (call_->Read(&response)) continue;
    auto status = call_->Finish();
    call_.reset();
    return status;
  }

 private:
  void open(const pb::StreamFramesRequest& request) {
    call_->Write(request);
    pb::StreamFramesResponse response;
    if (call_->Read(&response) && response.has_opened()) opened_ = response.opened();
  }

  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<pb::StreamFramesRequest, pb::StreamFramesResponse>> call_;
  std::optional<pb::StreamOpened> opened_;
};

}  // namespace collided::test
