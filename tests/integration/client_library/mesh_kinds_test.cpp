// Scenes with rigid meshes, encoded positions and loose elements through the client library, whichever way they
// go.
#include <gtest/gtest.h>

#include "tests/integration/client_library/client_layers.hpp"
#include "tests/integration/client_library/client_ways.hpp"

namespace collided::test {
namespace {

using client::Error;
using client::MeshInput;
using client::RigidMatrix;
using Points = std::vector<std::array<double, 3>>;

constexpr std::array<std::array<uint32_t, 3>, 1> kOne{{{0, 1, 2}}};
const Points kBody{{-1, -1, 1}, {1, -1, 1}, {0, 1, 1}}, kGround{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};
constexpr RigidMatrix kHere{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, kBelow{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -2};

/// A body over the ground. `format`: of all positions.
pb::Scene make_scene(Client& client, pb::PositionFormat format, bool is_rigid) {
  pb::SceneSpec spec;
  spec.set_mode(pb::DETECTION_MODE_CCD);
  spec.set_position_format(format);
  if (format == pb::POSITION_FORMAT_Q16)
    for (int k = 0; k < 3; ++k)
      spec.mutable_quantization_box()->add_lower(-10), spec.mutable_quantization_box()->add_upper(10);
  const MeshInput meshes[] = {{.name = "body", .vertex_count = 3, .triangles = kOne, .is_rigid = is_rigid},
                              {.name = "ground", .vertex_count = 3, .triangles = kOne, .is_static = true}};
  return client.create_scene(spec, meshes);
}

std::string packed(const pb::Scene& scene, const Points& points) {
  const pb::SceneSpec& spec = scene.spec();
  return spec.position_format() == pb::POSITION_FORMAT_Q16 ? client::pack_quantized(points, spec.quantization_box())
                                                           : client::pack_positions(points, spec.position_format());
}

pb::Frame first_frame(const pb::Scene& scene) {
  pb::Frame frame;
  frame.set_frame_id(1);
  for (uint32_t mesh = 0; mesh < 2; ++mesh) {
    pb::MeshUpdate& update = *frame.add_updates();
    update.set_mesh(mesh);
    update.set_positions(packed(scene, mesh == 0 ? kBody : kGround));
  }
  return frame;
}

FrameOutput answer_to(FrameStream& stream, const pb::Frame& frame) {
  stream.send(frame);
  return stream.receive();
}

FrameOutput answer_to(FrameStream& stream, uint64_t id, const client::FrameUpdate& update) {
  stream.send(id, {&update, 1});
  return stream.receive();
}

class MeshKinds : public ::testing::TestWithParam<Way> {
 protected:
  FrameStream open(const pb::Scene& scene) { return client_.stream(scene, {.local = {.use = use_of(GetParam())}}); }

  LocalDaemon daemon_{{}};
  Client client_ = client_by(GetParam(), daemon_.process().address());
};

TEST_P(MeshKinds, ARigidMeshIsMovedByTwelveNumbers) {
  const pb::Scene scene = make_scene(client_, pb::POSITION_FORMAT_F32, true);
  EXPECT_EQ(scene.spec().meshes(0).motion(), pb::MESH_MOTION_RIGID);
  FrameStream stream = open(scene);
  answer_to(stream, first_frame(scene)).check();
  const FrameOutput output = answer_to(stream, 2, {.mesh = 0, .transform = &kBelow});
  output.check();
  EXPECT_EQ(output.done.metrics().bytes_in(), 96u);
  EXPECT_EQ(output.vertex_triangle.count, 3u);
  EXPECT_NEAR(output.done.earliest_toi(), 0.5, 1e-6);
}

TEST_P(MeshKinds, EveryFrameMayTellWhereARigidMeshBegins) {
  const pb::Scene scene = make_scene(client_, pb::POSITION_FORMAT_F32, true);
  FrameStream stream = open(scene);
  answer_to(stream, first_frame(scene)).check();
  const FrameOutput fall = answer_to(stream, 2, {.mesh = 0, .transform = &kBelow, .start_transform = &kBelow});
  fall.check();
  EXPECT_FALSE(fall.done.any_contact());
  const FrameOutput lost = answer_to(stream, 3, {.mesh = 0, .start_transform = &kBelow});
  ASSERT_TRUE(lost.error);
  EXPECT_EQ(lost.error->field(), "frame.updates[0].rigid.matrix");
}

// As a frame that the caller made, or from the caller's memory.
TEST_P(MeshKinds, AMessageMovesARigidMeshAsAnUpdateDoes) {
  const pb::Scene scene = make_scene(client_, pb::POSITION_FORMAT_F32, true);
  FrameStream stream = open(scene);
  answer_to(stream, first_frame(scene)).check();
  pb::Frame fall;
  fall.set_frame_id(2);
  *fall.add_updates() = client::rigid_update(0, kBelow, kHere);
  const FrameOutput message = answer_to(stream, fall);
  const FrameOutput update = answer_to(stream, 3, {.mesh = 0, .transform = &kBelow, .start_transform = &kHere});
  EXPECT_EQ(message.done.metrics().bytes_in(), 192u);
  EXPECT_EQ(update.done.metrics().bytes_in(), 192u);
  EXPECT_EQ(message.vertex_triangle.elements, update.vertex_triangle.elements);
  EXPECT_EQ(message.vertex_triangle.toi, update.vertex_triangle.toi);
  EXPECT_EQ(update.vertex_triangle.count, 3u);
}

TEST_P(MeshKinds, MovesThatARigidMeshCannotMakeAreRefusedAndTheStreamGoesOn) {
  const pb::Scene scene = make_scene(client_, pb::POSITION_FORMAT_F32, true);
  FrameStream stream = open(scene);
  answer_to(stream, first_frame(scene)).check();
  RigidMatrix stretched = kHere;
  stretched[0] = 2;
  const FrameOutput refused = answer_to(stream, 2, {.mesh = 0, .transform = &stretched});
  ASSERT_TRUE(refused.error);
  EXPECT_EQ(refused.error->field(), "frame.updates[0].rigid.matrix");
  EXPECT_EQ(refused.error->code(), grpc::INVALID_ARGUMENT);
  pb::Frame positions;
  positions.set_frame_id(3);
  positions.add_updates()->set_positions(packed(scene, kBody));
  EXPECT_EQ(answer_to(stream, positions).error->field(), "frame.updates[0].positions");
  EXPECT_EQ(answer_to(stream, 4, {.mesh = 0, .transform = &kBelow}).vertex_triangle.count, 3u);
}

TEST_P(MeshKinds, EncodedPositionsTakeHalfTheBytesAndMissNothing) {
  const pb::Scene scene = make_scene(client_, pb::POSITION_FORMAT_Q16, false);
  EXPECT_EQ(scene.spec().quantization_box().upper(2), 10);
  FrameStream stream = open(scene);
  const FrameOutput first = answer_to(stream, first_frame(scene));
  first.check();
  EXPECT_EQ(first.done.metrics().bytes_in(), 2 * 3 * 6u);
  Points below = kBody;
  for (auto& p : below) p[2] = -1;
  pb::Frame fall;
  fall.set_frame_id(2);
  fall.add_updates()->set_positions(packed(scene, below));
  const FrameOutput output = answer_to(stream, fall);
  output.check();
  EXPECT_EQ(output.vertex_triangle.count, 3u);
  EXPECT_LE(output.done.earliest_toi(), 0.5);
  EXPECT_GT(output.done.earliest_toi(), 0.499);
  for (const uint8_t flags : output.vertex_triangle.flags) EXPECT_EQ(flags & pb::CONTACT_FLAG_CERTIFIED, 0);
}

/// Of a loose edge over a triangle, and a particle over the edge. The triangle's mesh has an edge, too, far below.
pb::Frame loose_frame(uint64_t id, double edge, double particle) {
  pb::Frame frame;
  frame.set_frame_id(id);
  const Points hair{{0, 0, edge}, {1, 0, edge}}, drop{{0.25, 0, particle}};
  *frame.add_updates() = client::mesh_update(0, pb::POSITION_FORMAT_F64, hair);
  *frame.add_updates() = client::mesh_update(1, pb::POSITION_FORMAT_F64, drop);
  Points ground = kGround;
  ground.insert(ground.end(), {{0, 0, -9}, {1, 0, -9}});
  if (id == 1) *frame.add_updates() = client::mesh_update(2, pb::POSITION_FORMAT_F64, ground);
  return frame;
}

TEST_P(MeshKinds, LooseElementsMeetEachOtherAndTriangles) {
  constexpr std::array<std::array<uint32_t, 2>, 1> kSegment{{{0, 1}}}, kDeep{{{4, 3}}};
  constexpr std::array<uint32_t, 1> kDrop{0};
  pb::SceneSpec spec;
  spec.set_mode(pb::DETECTION_MODE_DCD);
  spec.set_thickness(0.25);
  spec.set_position_format(pb::POSITION_FORMAT_F64);
  const MeshInput meshes[] = {
      {.name = "hair", .vertex_count = 2, .edges = kSegment},
      {.name = "drop", .vertex_count = 1, .points = kDrop},
      {.name = "ground", .vertex_count = 5, .triangles = kOne, .is_static = true, .edges = kDeep}};
  EXPECT_EQ(client_.estimate_scene(spec, meshes).triangle_count(), 1u);
  const pb::Scene scene = client_.create_scene(spec, meshes);
  EXPECT_EQ(scene.state(), pb::SCENE_STATE_READY);
  EXPECT_EQ(scene.triangle_count(), 1u);
  EXPECT_EQ(scene.edge_count(), 5u);
  EXPECT_EQ(scene.spec().meshes(0).edge_count(), 1u);
  EXPECT_EQ(scene.spec().meshes(1).point_count(), 1u);
  FrameStream stream = open(scene);
  EXPECT_EQ(answer_to(stream, loose_frame(1, 2, 3)).done.contact_count(), 0u);
  auto watcher = client_.watch(scene.scene_id(), {.max_contacts_per_kind = 10});
  // The drop on the hair, the hair on the ground: its ends, and no edge of the ground.
  const FrameOutput output = answer_to(stream, loose_frame(2, 0.25, 0.5));
  output.check();
  const std::vector<std::array<uint32_t, 4>> expected = {{0, 3, 4, 5}, {1, 3, 4, 5}, {2, 0, 1, 1}};
  EXPECT_EQ(output.vertex_triangle.stencils, expected);
  EXPECT_EQ(output.vertex_triangle.elements, (std::vector<std::array<uint32_t, 2>>{{0, 2}, {1, 2}, {2, 0}}));
  EXPECT_EQ(output.edge_edge.count, 0u);
  EXPECT_EQ(client::element_kind(expected[0]), client::ElementKind::kTriangle);
  EXPECT_EQ(client::element_kind(expected[2]), client::ElementKind::kEdge);
  EXPECT_EQ(client::element_kind({2, 0, 0, 0}), client::ElementKind::kPoint);
  client::WatchedFrame shown = watcher.receive();
  while (shown.frame_id < output.frame_id) shown = watcher.receive();  // the one before it may come first
  EXPECT_EQ(shown.vertex_triangle.stencils, expected);
}

INSTANTIATE_TEST_SUITE_P(Transports, MeshKinds, ::testing::ValuesIn(kEveryWay),
                         [](const auto& info) { return name_of(info.param); });

}  // namespace
}  // namespace collided::test
