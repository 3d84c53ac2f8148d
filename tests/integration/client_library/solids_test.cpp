// A small cube in, at and beside a large one, both solids, through the client library, whichever way frames go.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/integration/client_library/client_ways.hpp"

namespace collided::test {
namespace {

using client::Client;
using client::Error;
using client::FrameOutput;
using client::FrameStream;
using client::MeshInput;
using client::MeshPair;
using Point = std::array<double, 3>;

constexpr double kSide = 10, kDistance = 4.5;
constexpr uint32_t kCorners = 8;
// Corner i is at the far end of the axes whose bits i has.
constexpr std::array<std::array<uint32_t, 3>, 12> kCube{{{0, 2, 1},
                                                         {1, 2, 3},
                                                         {4, 5, 6},
                                                         {5, 7, 6},
                                                         {0, 1, 4},
                                                         {1, 5, 4},
                                                         {2, 6, 3},
                                                         {3, 6, 7},
                                                         {0, 4, 2},
                                                         {2, 4, 6},
                                                         {1, 3, 5},
                                                         {3, 7, 5}}};

std::vector<Point> cube_at(const Point& lower, double side) {
  std::vector<Point> corners;
  for (uint32_t i = 0; i < kCorners; ++i)
    corners.push_back({lower[0] + side * (i & 1), lower[1] + side * (i >> 1 & 1), lower[2] + side * (i >> 2)});
  return corners;
}

MeshInput solid(const char* name, bool is_static) {
  return {.name = name,
          .vertex_count = kCorners,
          .triangles = kCube,
          .is_static = is_static,
          .no_self_contacts = true,
          .solid = true};
}

/// How deep a point is in the large cube.
double depth_of(const Point& p) {
  double depth = kSide;
  for (const double x : p) depth = std::min({depth, x, kSide - x});
  return depth;
}

pb::SceneSpec spec_of_all() {
  pb::SceneSpec spec;
  spec.set_mode(pb::DETECTION_MODE_DCD);
  spec.set_accuracy(pb::ACCURACY_EXACT);
  spec.set_position_format(pb::POSITION_FORMAT_F64);
  spec.set_thickness(kDistance);
  for (const auto kind : {pb::CONTACT_KIND_VERTEX_TRIANGLE, pb::CONTACT_KIND_EDGE_EDGE, pb::CONTACT_KIND_VERTEX_SOLID})
    spec.add_kinds(kind);
  for (const auto field :
       {pb::CONTACT_FIELD_ELEMENTS, pb::CONTACT_FIELD_STENCIL, pb::CONTACT_FIELD_DISTANCE, pb::CONTACT_FIELD_WEIGHTS,
        pb::CONTACT_FIELD_NORMAL, pb::CONTACT_FIELD_PAIR_STATES, pb::CONTACT_FIELD_SIGNED_DISTANCE})
    spec.add_fields(field);
  return spec;
}

pb::Scene make_scene(Client& client) {
  const MeshInput meshes[] = {solid("large", true), solid("small", false)};
  return client.create_scene(spec_of_all(), meshes);
}

class Solids : public ::testing::TestWithParam<Way> {
 protected:
  /// The answer with the small cube there.
  FrameOutput at(FrameStream& stream, uint64_t id, const std::vector<Point>& small) {
    pb::Frame frame;
    frame.set_frame_id(id);
    if (id == 1) *frame.add_updates() = client::mesh_update(0, pb::POSITION_FORMAT_F64, cube_at({0, 0, 0}, kSide));
    *frame.add_updates() = client::mesh_update(1, pb::POSITION_FORMAT_F64, small);
    stream.send(frame);
    FrameOutput output = stream.receive();
    output.check();
    EXPECT_FALSE(output.done.has_pairs());
    EXPECT_EQ(output.done.metrics().counts().contacts_vertex_solid(), output.vertex_solid.count);
    EXPECT_EQ(output.done.metrics().counts().inside_out(), 0u);
    return output;
  }
  FrameStream open(const pb::Scene& scene) { return client_.stream(scene, {.local = {.use = use_of(GetParam())}}); }

  LocalDaemon daemon_{{}};
  Client client_ = client_by(GetParam(), daemon_.process().address());
};

TEST_P(Solids, WhatIsInsideIsFoundWithItsDepthAndItsWayOut) {
  const pb::Scene scene = make_scene(client_);
  EXPECT_TRUE(scene.spec().meshes(0).solid() && scene.spec().meshes(1).solid());
  FrameStream stream = open(scene);
  const std::vector<Point> small = cube_at({4, 4, 4}, 1);
  const FrameOutput output = at(stream, 1, small);
  const client::Contacts& inside = output.vertex_solid;
  ASSERT_EQ(inside.count, kCorners);
  ASSERT_EQ(inside.distance.size(), kCorners);
  ASSERT_EQ(inside.normals.size(), kCorners);
  EXPECT_TRUE(inside.signed_distances.empty() && inside.toi.empty() && inside.features.empty());
  for (uint32_t i = 0; i < kCorners; ++i) {
    EXPECT_EQ(inside.elements[i][0], kCorners + i);
    EXPECT_LT(inside.elements[i][1], kCube.size());
    EXPECT_EQ(inside.stencils[i][0], kCorners + i);
    EXPECT_DOUBLE_EQ(inside.distance[i], -depth_of(small[i]));
    Point out = small[i];
    for (size_t k = 0; k < 3; ++k) out[k] += depth_of(small[i]) * static_cast<double>(inside.normals[i][k]);
    EXPECT_NEAR(depth_of(out), 0, 1e-6);
  }
  ASSERT_EQ(output.pairs.size(), 1u);
  const MeshPair& pair = output.pairs[0];
  EXPECT_EQ(std::pair(pair.first, pair.second), std::pair(0u, 1u));
  EXPECT_EQ(pair.state, pb::MESH_PAIR_STATE_SECOND_INSIDE);
  EXPECT_EQ(std::pair(pair.first_inside, pair.second_inside), std::pair(0u, kCorners));
  EXPECT_EQ(pair.deepest, 2 * kCorners - 1);
  EXPECT_DOUBLE_EQ(pair.depth, 5);
}

TEST_P(Solids, DistancesHaveASign) {
  const pb::Scene scene = make_scene(client_);
  FrameStream stream = open(scene);
  const client::Contacts inside = at(stream, 1, cube_at({4, 4, 4}, 1)).vertex_triangle;
  EXPECT_GE(inside.count, kCorners - 1);  // all but the one that is 5 deep
  ASSERT_EQ(inside.signed_distances.size(), inside.count);
  for (size_t i = 0; i < inside.count; ++i) EXPECT_EQ(inside.signed_distances[i], -inside.distance[i]);
  const client::Contacts outside = at(stream, 2, cube_at({4, 4, 12}, 1)).vertex_triangle;
  EXPECT_GE(outside.count, kCorners);
  ASSERT_EQ(outside.signed_distances.size(), outside.count);
  for (size_t i = 0; i < outside.count; ++i) EXPECT_EQ(outside.signed_distances[i], outside.distance[i]);
}

TEST_P(Solids, ThatAreApartTouchAndOverlap) {
  const pb::Scene scene = make_scene(client_);
  FrameStream stream = open(scene);
  const FrameOutput apart = at(stream, 1, cube_at({4, 4, 12}, 1));
  EXPECT_EQ(apart.vertex_solid.count, 0u);
  EXPECT_TRUE(apart.pairs.empty());

  const FrameOutput touching = at(stream, 2, cube_at({4, 4, 10}, 1));
  EXPECT_EQ(touching.vertex_solid.count, 0u);
  ASSERT_EQ(touching.pairs.size(), 1u);
  EXPECT_EQ(touching.pairs[0].state, pb::MESH_PAIR_STATE_TOUCHING);
  EXPECT_EQ(touching.pairs[0].deepest, MeshPair::kNoVertex);
  EXPECT_EQ(touching.pairs[0].depth, 0);

  const FrameOutput overlapping = at(stream, 3, cube_at({4, 4, 9.5}, 1));
  EXPECT_EQ(overlapping.vertex_solid.count, 4u);
  ASSERT_EQ(overlapping.pairs.size(), 1u);
  const MeshPair& pair = overlapping.pairs[0];
  EXPECT_EQ(pair.state, pb::MESH_PAIR_STATE_OVERLAPPING);
  EXPECT_EQ(std::pair(pair.first_inside, pair.second_inside), std::pair(0u, 4u));
  EXPECT_EQ(pair.deepest, kCorners);  // the least of four that are as deep
  EXPECT_DOUBLE_EQ(pair.depth, 0.5);
}

// What a watch shows is bounded.
TEST_P(Solids, AWatcherSeesContactsWithoutPairs) {
  if (GetParam() == Way::kInProcess) GTEST_SKIP() << "what is shown of a frame depends on no transport";
  const pb::Scene scene = make_scene(client_);
  client::Watcher watcher = client_.watch(scene.scene_id(), {.max_contacts_per_kind = 100});
  FrameStream stream = open(scene);
  const FrameOutput output = at(stream, 1, cube_at({4, 4, 4}, 1));
  const client::WatchedFrame shown = watcher.receive();
  EXPECT_EQ(shown.vertex_solid.distance, output.vertex_solid.distance);
  EXPECT_EQ(shown.vertex_triangle.signed_distances, output.vertex_triangle.signed_distances);
  EXPECT_FALSE(shown.done.has_pairs());
}

TEST_P(Solids, ASheetIsNoSolid) {
  const std::span<const std::array<uint32_t, 3>> open_cube = std::span(kCube).first(11);
  const MeshInput meshes[] = {{.name = "sheet", .vertex_count = kCorners, .triangles = open_cube, .solid = true}};
  try {
    client_.create_scene(spec_of_all(), meshes);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.field(), "spec.meshes[0].solid") << e.message();
    EXPECT_NE(e.message().find("edge"), std::string::npos) << e.message();
  }
}

TEST_P(Solids, NormalsPointOutwards) {
  std::vector<std::array<uint32_t, 3>> reversed(kCube.begin(), kCube.end());
  for (auto& triangle : reversed) std::swap(triangle[0], triangle[1]);
  const MeshInput meshes[] = {{.name = "large", .vertex_count = kCorners, .triangles = kCube},
                              {.name = "small", .vertex_count = kCorners, .triangles = reversed, .solid = true}};
  FrameStream stream = open(client_.create_scene(spec_of_all(), meshes));
  pb::Frame frame;
  frame.set_frame_id(1);
  *frame.add_updates() = client::mesh_update(0, pb::POSITION_FORMAT_F64, cube_at({0, 0, 0}, kSide));
  *frame.add_updates() = client::mesh_update(1, pb::POSITION_FORMAT_F64, cube_at({4, 4, 4}, 1));
  stream.send(frame);
  const FrameOutput output = stream.receive();
  ASSERT_TRUE(output.error);
  EXPECT_EQ(output.error->field(), "spec.meshes[1].solid");
  EXPECT_TRUE(output.error->message().starts_with("spec.meshes[1].solid is on, but ")) << output.error->message();
}

INSTANTIATE_TEST_SUITE_P(Every, Solids, ::testing::ValuesIn(kEveryWay),
                         [](const auto& way) { return name_of(way.param); });

}  // namespace
}  // namespace collided::test
