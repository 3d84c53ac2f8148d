#pragma once
// A scene whose contacts are known: the lowest corner of a triangle ("tip") falls from z = 1 to 1 - depth through the
// inside of a triangle in z = 0 ("floor"). For depth > 1 there is one contact, vertex 3 with triangle 0, at 1 / depth.

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "tests/integration/support/calls.hpp"
#include "tests/integration/support/positions.hpp"
#include "tests/integration/support/stream.hpp"

namespace collided::test {

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

}  // namespace collided::test
