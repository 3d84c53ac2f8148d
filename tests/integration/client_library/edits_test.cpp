// Scenes that are edited while frames flow, whichever way they go.
#include <gtest/gtest.h>

#include <cmath>

#include "client/cpp/transport/grpc/channel.hpp"
#include "tests/integration/client_library/client_layers.hpp"
#include "tests/integration/client_library/client_ways.hpp"
#include "tests/integration/support/watch.hpp"

namespace collided::test {
namespace {

using client::MeshInput;
using Points3 = std::vector<std::array<double, 3>>;

constexpr std::array<std::array<uint32_t, 3>, 1> kOne{{{0, 1, 2}}};
constexpr std::array<std::array<uint32_t, 3>, 2> kTwo{{{0, 1, 2}, {0, 3, 2}}};

MeshInput body(const std::string& name) { return {.name = name, .vertex_count = 3, .triangles = kOne}; }
/// Its lowest corner is at x, y = 0 and z.
Points3 body_at(double x, double z) { return {{x, 0, z}, {x - 0.1, 0, z + 8}, {x + 0.1, 0, z + 8}}; }
const Points3 kGround{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};

pb::Scene make_scene(Client& client) {
  pb::SceneSpec spec;
  spec.set_mode(pb::DETECTION_MODE_CCD);
  const MeshInput meshes[] = {{.name = "ground", .vertex_count = 3, .triangles = kOne, .is_static = true},
                              body("first")};
  return client.create_scene(spec, meshes);
}

pb::Frame frame_of(uint64_t id) {
  pb::Frame frame;
  frame.set_frame_id(id);
  return frame;
}
/// A body that falls from z = 1 to -1 and so meets the ground.
void fall(pb::Frame& frame, uint32_t mesh, double x) {
  *frame.add_updates() = client::mesh_update(mesh, pb::POSITION_FORMAT_F32, body_at(x, -1), body_at(x, 1));
}
pb::Frame first_frame() {
  pb::Frame frame = frame_of(1);
  *frame.add_updates() = client::mesh_update(0, pb::POSITION_FORMAT_F32, kGround);
  fall(frame, 1, 0);
  return frame;
}

class Edits : public ::testing::TestWithParam<Way> {
 protected:
  FrameStream open(uint32_t window = 4, pb::DeliveryPolicy delivery = pb::DELIVERY_POLICY_UNSPECIFIED) {
    return client_.stream(
        scene_, {.window = window, .delivery = delivery, .local = {.use = use_of(GetParam()), .edit_bytes = 1u << 16}});
  }
  pb::Scene now() { return client_.get_scene(scene_.scene_id()); }

  LocalDaemon daemon_{{}};
  Client client_ = client_by(GetParam(), daemon_.process().address());
  const pb::Scene scene_ = make_scene(client_);
};

/// Vertices that meet a triangle.
std::vector<uint32_t> met_by(const FrameOutput& output) {
  output.check();
  std::vector<uint32_t> vertices;
  for (const auto& [vertex, triangle] : output.vertex_triangle.elements) vertices.push_back(vertex);
  return vertices;
}

// None waits for the one before it. A second body comes, the first one goes, and its number is filled again.
TEST_P(Edits, AreAppliedInTheOrderOfTheFrames) {
  FrameStream stream = open();
  std::vector<pb::Frame> frames{first_frame()};
  for (uint64_t id = 2; id <= 7; ++id) {
    frames.push_back(frame_of(id));
    if (id != 4 && id != 5) fall(frames.back(), 1, 0);
    if (id != 2 && id != 7) fall(frames.back(), 2, 1);
  }
  *frames[2].mutable_edit()->add_meshes() = client::edited_mesh(2, body("second"));
  *frames[3].mutable_edit()->add_meshes() = client::removed_mesh(1);
  *frames[5].mutable_edit()->add_meshes() = client::edited_mesh(1, body("third"));
  pb::MeshPair& pair = *frames[6].mutable_edit()->add_exclude_meshes();
  pair.set_first(2), pair.set_second(0);
  std::vector<std::vector<uint32_t>> met;
  for (const pb::Frame& frame : frames) stream.send(frame);
  for (size_t i = 0; i < frames.size(); ++i) met.push_back(met_by(stream.receive()));
  const std::vector<std::vector<uint32_t>> expected{{3}, {3}, {3, 6}, {3}, {3}, {3, 6}, {3}};
  EXPECT_EQ(met, expected);
  const pb::Scene after = now();
  EXPECT_EQ(after.edit_count(), 4u);
  EXPECT_EQ(after.vertex_count(), 9u);
  EXPECT_EQ(after.triangle_count(), 3u);
  ASSERT_EQ(after.spec().meshes_size(), 3);
  EXPECT_EQ(after.spec().meshes(1).name(), "third");
  EXPECT_EQ(after.spec().excluded_meshes_size(), 1);
}

TEST_P(Edits, ATearBeginsWhereItSays) {
  FrameStream stream = open();
  stream.send(first_frame());
  stream.receive().check();
  pb::Frame tear = frame_of(2);
  *tear.mutable_edit()->add_meshes() = client::edited_mesh(1, {.vertex_count = 4, .triangles = kTwo});
  Points3 torn = body_at(0, 1), fallen = body_at(0, -1);
  torn.push_back({2, 0, 1}), fallen.push_back({2, 0, -1});
  *tear.add_updates() = client::mesh_update(1, pb::POSITION_FORMAT_F32, fallen);
  stream.send(tear);
  const FrameOutput refused = stream.receive();
  ASSERT_TRUE(refused.error);
  EXPECT_EQ(refused.error->field(), "frame.updates[0].start_positions");
  tear.set_frame_id(3);
  *tear.mutable_updates(0) = client::mesh_update(1, pb::POSITION_FORMAT_F32, fallen, torn);
  stream.send(tear);
  EXPECT_EQ(met_by(stream.receive()), (std::vector<uint32_t>{3, 6}));
  EXPECT_EQ(now().spec().meshes(1).name(), "first");  // it kept its name
}

// The body is one below the ground, and stands still.
TEST_P(Edits, AMeshGetsThickerAndThinner) {
  FrameStream stream = open();
  stream.send(first_frame());
  stream.receive().check();
  uint64_t id = 2;
  for (const double half : {0.5, 1.25, 0.75}) {
    pb::Frame frame = frame_of(id++);
    *frame.mutable_edit()->add_meshes() = client::edited_mesh(1, {.vertex_count = 3, .half_thickness = half});
    stream.send(frame);
    EXPECT_EQ(met_by(stream.receive()), half > 1 ? std::vector<uint32_t>{3} : std::vector<uint32_t>{}) << half;
    EXPECT_EQ(now().spec().meshes(1).half_thickness(), half);
  }
}

// Each is answered, names what is wrong, and leaves the scene as it was.
TEST_P(Edits, RefusedOnesLeaveTheScene) {
  FrameStream stream = open();
  stream.send(first_frame());
  stream.receive().check();
  uint64_t id = 2;
  const auto refused = [&](const std::function<void(pb::Frame&)>& change) {
    pb::Frame frame = frame_of(id++);
    change(frame);
    stream.send(frame);
    const FrameOutput output = stream.receive();
    return output.error ? output.error->field() : "";
  };
  const auto with_mesh = [](uint32_t mesh, MeshInput input) {
    return [mesh, input](pb::Frame& f) { *f.mutable_edit()->add_meshes() = client::edited_mesh(mesh, input); };
  };
  const std::array<std::array<uint32_t, 3>, 1> far_index{{{0, 1, 7}}}, twice{{{0, 1, 1}}};
  EXPECT_EQ(refused(with_mesh(3, body("second"))), "frame.edit.meshes[0].mesh");
  EXPECT_EQ(refused(with_mesh(2, body(""))), "frame.edit.meshes[0].spec.name");
  EXPECT_EQ(refused(with_mesh(2, body("ground"))), "frame.edit.meshes[0].spec.name");
  EXPECT_EQ(refused(with_mesh(2, body(std::string(129, 'x')))), "frame.edit.meshes[0].spec.name");
  EXPECT_EQ(refused(with_mesh(2, {.name = "b", .vertex_count = 2, .triangles = kOne})),
            "frame.edit.meshes[0].spec.vertex_count");
  EXPECT_EQ(refused(with_mesh(2, {.name = "b", .vertex_count = 3, .triangles = far_index})),
            "frame.edit.meshes[0].spec.triangles[0]");
  EXPECT_EQ(refused(with_mesh(2, {.name = "b", .vertex_count = 3, .triangles = twice})),
            "frame.edit.meshes[0].spec.triangles[0]");
  EXPECT_EQ(refused(with_mesh(1, {.vertex_count = 4})), "frame.edit.meshes[0].spec.triangles");
  EXPECT_EQ(refused(with_mesh(1, {.vertex_count = 3, .triangles = kOne, .exclude_rings = 9})),
            "frame.edit.meshes[0].spec.exclude_rings");
  for (const double half : {-1.0, std::nan(""), HUGE_VAL, 1e300})
    EXPECT_EQ(refused(with_mesh(1, {.vertex_count = 3, .half_thickness = half})),
              "frame.edit.meshes[0].spec.half_thickness");
  EXPECT_EQ(refused(with_mesh(2, body("second"))), "frame.updates");  // without its positions
  EXPECT_EQ(refused([](pb::Frame& f) { *f.mutable_edit()->add_meshes() = client::removed_mesh(2); }),
            "frame.edit.meshes[0]");
  EXPECT_EQ(refused([](pb::Frame& f) {
              for (const uint32_t mesh : {0, 1}) *f.mutable_edit()->add_meshes() = client::removed_mesh(mesh);
            }),
            "frame.edit.meshes");
  EXPECT_EQ(refused([](pb::Frame& f) { f.mutable_edit()->add_include_meshes()->set_first(1); }),
            "frame.edit.include_meshes[0]");
  EXPECT_EQ(refused([](pb::Frame& f) { f.mutable_edit()->add_exclude_meshes()->set_second(2); }),
            "frame.edit.exclude_meshes[0]");
  EXPECT_EQ(refused([](pb::Frame& f) {
              f.mutable_edit();
              f.set_trial(true);
            }),
            "frame.edit");
  EXPECT_EQ(refused([](pb::Frame& f) {
              for (int i = 0; i < 257; ++i) *f.mutable_edit()->add_meshes() = client::removed_mesh(1);
            }),
            "frame.edit.meshes");
  EXPECT_EQ(refused([](pb::Frame& f) { fall(f, 2, 0); }), "frame.updates[0].mesh");
  EXPECT_EQ(refused([](pb::Frame& f) { f.mutable_edit(); }), "");  // nothing changes
  pb::Frame good = frame_of(id);
  fall(good, 1, 0);
  stream.send(good);
  EXPECT_EQ(met_by(stream.receive()), std::vector<uint32_t>{3});
  EXPECT_EQ(now().edit_count(), 1u);
}

// Frames that later ones would replace are skipped; none with an edit is, and none that is before it.
TEST_P(Edits, AreNeverSkipped) {
  FrameStream stream = open(8, pb::DELIVERY_POLICY_LATEST_WINS);
  stream.send(first_frame());
  constexpr uint64_t kLast = 60;
  for (uint64_t id = 2; id <= kLast; ++id) {
    pb::Frame frame = frame_of(id);
    fall(frame, 1, 0);
    if (id % 10 == 0)
      *frame.mutable_edit()->add_meshes() =
          id % 20 == 0 ? client::removed_mesh(2) : client::edited_mesh(2, body("second"));
    if (id % 20 == 10) fall(frame, 2, 1);
    stream.send(frame);
  }
  for (uint64_t id = 1; id <= kLast; ++id) {
    const FrameOutput output = stream.receive();
    ASSERT_EQ(output.frame_id, id);
    EXPECT_FALSE(output.skipped && id % 10 == 0) << id;
    if (output.skipped) continue;
    output.check();
    EXPECT_EQ(output.vertex_triangle.count, id % 20 == 10 ? 2u : 1u) << id;
  }
  EXPECT_EQ(now().edit_count(), 6u);
}

/// What is shown of a frame; the one before it may come first.
std::optional<pb::WatchSceneResponse> shown_of(Watch& watch, uint64_t frame_id) {
  auto shown = watch.next();
  while (shown && shown->frame_id() < frame_id) shown = watch.next();
  return shown;
}

// Watchers follow: they are told that the scene was edited, and see all of what a mesh has become.
TEST_P(Edits, AreSeenByWatchers) {
  FrameStream stream = open();
  stream.send(first_frame());
  stream.receive().check();
  const auto stub = pb::CollisionService::NewStub(client_.channels().connect());
  Watch watch(*stub, watch_request(scene_.scene_id(), [](pb::WatchSceneRequest& r) { r.add_position_meshes(1); }));
  ASSERT_TRUE(watch.opened());
  pb::Frame tear = frame_of(2);
  *tear.mutable_edit()->add_meshes() = client::edited_mesh(1, {.vertex_count = 4, .triangles = kTwo});
  Points3 torn = body_at(0, 1);
  torn.push_back({2, 0, 1});
  *tear.add_updates() = client::mesh_update(1, pb::POSITION_FORMAT_F32, torn, torn);
  stream.send(tear);
  stream.receive().check();
  const auto shown = shown_of(watch, 2);
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->edit_count(), 1u);
  ASSERT_EQ(shown->positions_size(), 1);
  EXPECT_EQ(shown->positions(0).positions(), client::pack_positions(torn, pb::POSITION_FORMAT_F32));
  pb::Frame removal = frame_of(3);
  *removal.mutable_edit()->add_meshes() = client::removed_mesh(1);
  stream.send(removal);
  stream.receive().check();
  const auto last = shown_of(watch, 3);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->edit_count(), 2u);
  EXPECT_EQ(last->positions(0).positions(), "");
}

INSTANTIATE_TEST_SUITE_P(Over, Edits, ::testing::ValuesIn(kEveryWay),
                         [](const auto& info) { return name_of(info.param); });

// One frame in one call.
TEST(EditsOfOneFrame, AreTakenByDetectFrameToo) {
  LocalDaemon daemon{{}};
  Client client = Client::connect(daemon.process().address());
  const pb::Scene scene = make_scene(client);
  ASSERT_TRUE(detect(daemon.stub(), scene.scene_id(), first_frame()).ok());
  pb::Frame edit = frame_of(2);
  *edit.mutable_edit()->add_meshes() = client::edited_mesh(2, body("second"));
  fall(edit, 2, 1);
  pb::DetectFrameResponse answer;
  ASSERT_TRUE(detect(daemon.stub(), scene.scene_id(), edit, &answer).ok());
  EXPECT_EQ(answer.done().contact_count(), 1u);
  EXPECT_EQ(client.get_scene(scene.scene_id()).spec().meshes(2).name(), "second");
}

}  // namespace
}  // namespace collided::test
