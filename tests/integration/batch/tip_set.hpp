#pragma once
// A set of tips (support/tip_scene.hpp): the tip of each world falls as deep as its frame says.

#include <limits>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {

inline pb::CreateScenesRequest tip_set_request(uint32_t count) {
  pb::CreateScenesRequest request;
  *request.mutable_spec() = tip_request().spec();
  request.set_count(count);
  return request;
}

inline grpc::Status create_scenes(Stub& stub, const pb::CreateScenesRequest& request, pb::Scene* scenes = nullptr) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::CreateScenesResponse response;
  const auto status = stub.CreateScenes(&context, request, &response);
  if (scenes) *scenes = response.scenes();
  return status;
}

inline std::string make_set(Stub& stub, const pb::CreateScenesRequest& request) {
  pb::Scene scenes;
  const auto status = create_scenes(stub, request, &scenes);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return scenes.scene_id();
}

inline grpc::Status detect(Stub& stub, const pb::DetectBatchRequest& request, pb::DetectBatchResponse* response) {
  grpc::ClientContext context;
  set_deadline(context);
  return stub.DetectBatch(&context, request, response);
}

/// Positions of worlds whose tips fall so deep, from z = 1; with those of the floor where it is a first frame.
struct Falls {
  std::string start, end;
};
inline Falls falls(const std::vector<double>& depths, bool first) {
  Falls all;
  for (const double depth : depths) {
    const std::string floor = first ? pack_points(floor_points()) : "";
    all.start += floor + pack_points(tip_points(1));
    all.end += floor + pack_points(tip_points(1 - depth));
  }
  return all;
}

inline pb::SetFrame& add_frame(pb::DetectBatchRequest& batch, const std::string& set, uint64_t id,
                               const std::vector<double>& depths, bool first) {
  pb::SetFrame& frame = *batch.add_frames();
  const Falls of = falls(depths, first);
  frame.set_scene_id(set);
  frame.set_frame_id(id);
  frame.set_start_positions(of.start);
  frame.set_positions(of.end);
  return frame;
}

inline std::vector<uint64_t> begins(const pb::WorldContacts& contacts) {
  std::vector<uint64_t> begin(contacts.begin().size() / sizeof(uint64_t));
  std::memcpy(begin.data(), contacts.begin().data(), contacts.begin().size());
  return begin;
}

/// Which worlds of the frame have the tip's one contact.
inline std::vector<uint64_t> hits(const pb::SetAnswer& answer) {
  EXPECT_FALSE(answer.has_error()) << answer.error().message();
  std::vector<uint64_t> worlds;
  for (const pb::WorldContacts& contacts : answer.contacts()) {
    EXPECT_EQ(contacts.contacts().kind(), pb::CONTACT_KIND_VERTEX_TRIANGLE);
    const auto begin = begins(contacts);
    for (uint64_t i = 0; i + 1 < begin.size(); ++i)
      for (uint64_t k = begin[i]; k < begin[i + 1]; ++k) {
        EXPECT_EQ(contacts.contacts().elements().substr(8 * k, 8), pack<uint32_t>({3, 0}));
        EXPECT_EQ(contacts.contacts().stencils().substr(16 * k, 16), pack<uint32_t>({3, 0, 1, 2}));
        worlds.push_back(i);
      }
  }
  return worlds;
}

}  // namespace collided::test
