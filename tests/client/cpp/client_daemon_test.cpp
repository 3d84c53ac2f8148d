// The client library against its own daemon.

#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "client/app/daemon/own_daemon.hpp"
#include "client/cpp/client.hpp"
#include "client/cpp/transport/grpc/grpc_transport.hpp"

namespace collided::client {
namespace {

using Triangles = std::vector<std::array<uint32_t, 3>>;

const Triangles kTriangles{{0, 1, 2}, {3, 4, 5}};
const StreamOptions kOverGrpc{.local = {.use = Local::kOff}};  // its own daemon offers shared memory, too

/// A triangle at rest, and one whose corner is `height` above its inside.
std::vector<std::array<double, 3>> positions_at(double height) {
  return {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, height}, {1.5, 1, height + 2}, {1, 1.5, height + 2}};
}

template <class Call>
void expect_error(int code, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
  }
}

class ClientAndDaemon : public testing::Test {
 protected:
  ClientAndDaemon() : daemon(std::in_place, cli::DaemonOptions{.backend = "cpu", .threads = 1}) {}

  v1::Scene make_scene() {
    v1::SceneSpec spec;
    spec.set_mode(v1::DETECTION_MODE_CCD);
    spec.set_position_format(v1::POSITION_FORMAT_F64);
    const MeshInput mesh{.name = "two", .vertex_count = 6, .triangles = kTriangles};
    return client.create_scene(spec, {&mesh, 1});
  }
  /// Opens a stream with that message limit.
  FrameStream stream_of(const v1::Scene& scene, uint64_t max_message_bytes) {
    const auto channel = grpc::CreateChannel(daemon->address(), grpc::InsecureChannelCredentials());
    v1::OpenStream open;
    open.set_scene_id(scene.scene_id());
    return FrameStream::open(
        std::make_unique<GrpcTransport>(channel, std::make_unique<grpc::ClientContext>(), max_message_bytes), open);
  }
  static FrameOutput run(FrameStream& stream, uint64_t id, const std::vector<std::array<double, 3>>& positions) {
    const FrameUpdate update{.positions = std::as_bytes(std::span(positions))};
    stream.send(id, {&update, 1});
    return stream.receive();
  }

  std::optional<cli::OwnDaemon> daemon;
  Client client = Client::connect(daemon->address());
};

TEST_F(ClientAndDaemon, PositionsInTheCallersMemoryGiveTheContactsOfAFrame) {
  const v1::Scene light = make_scene(), whole = make_scene();
  FrameStream a = client.stream(light, kOverGrpc), b = client.stream(whole, kOverGrpc);
  for (uint64_t id = 1; id <= 4; ++id) {
    const auto positions = positions_at(id % 2 ? 1 : -1);
    v1::Frame frame;
    frame.set_frame_id(id);
    *frame.add_updates() = mesh_update(0, v1::POSITION_FORMAT_F64, positions);
    b.send(frame);
    const FrameOutput expected = b.receive(), found = run(a, id, positions);
    EXPECT_NO_THROW(found.check());
    EXPECT_EQ(found.frame_id, id);
    EXPECT_EQ(found.vertex_triangle.count, id == 1 ? 0u : 1u);
    EXPECT_EQ(found.vertex_triangle.toi, expected.vertex_triangle.toi);
    EXPECT_EQ(found.edge_edge.stencils, expected.edge_edge.stencils);
  }
  EXPECT_FALSE(a.draining_deadline());
  a.finish();
  b.finish();
}

TEST_F(ClientAndDaemon, ADaemonOfTheSameReleaseKnowsAllFieldsOfContacts) {
  EXPECT_EQ(client.contact_fields().size(), size_t{kColumnCount});
}

TEST_F(ClientAndDaemon, AWatcherSeesTheContactsAndPositionsOfFramesThatOthersSend) {
  const v1::Scene scene = make_scene();
  Watcher watcher = client.watch(scene.scene_id(), {.max_contacts_per_kind = 10, .meshes = {0}, .vertex_stride = 2});
  EXPECT_EQ(watcher.scene().scene_id(), scene.scene_id());
  EXPECT_EQ(watcher.vertex_stride(), 2u);
  FrameStream stream = client.stream(scene, kOverGrpc);
  for (uint64_t id = 1; id <= 3; ++id) {
    const auto positions = positions_at(id % 2 ? 1 : -1);
    const FrameOutput answered = run(stream, id, positions);
    const WatchedFrame shown = watcher.receive();
    EXPECT_EQ(shown.frame_id, id);
    EXPECT_EQ(shown.skipped_frames, 0u);
    EXPECT_EQ(shown.omitted_contacts, 0u);
    EXPECT_EQ(shown.done.contact_count(), answered.done.contact_count());
    EXPECT_EQ(shown.vertex_triangle.elements, answered.vertex_triangle.elements);
    EXPECT_EQ(shown.vertex_triangle.toi, answered.vertex_triangle.toi);
    ASSERT_EQ(shown.positions.size(), 1u);
    ASSERT_EQ(shown.positions[0].positions().size(), 3 * sizeof(positions[0]));
    for (size_t i = 0; i < 3; ++i)
      EXPECT_EQ(std::memcmp(shown.positions[0].positions().data() + i * sizeof(positions[0]), &positions[2 * i],
                            sizeof(positions[0])),
                0);
  }
  client.delete_scene(scene.scene_id());
  expect_error(grpc::NOT_FOUND, [&] { watcher.receive(); });
  expect_error(grpc::FAILED_PRECONDITION, [&] { watcher.receive(); });
}

TEST_F(ClientAndDaemon, MoveAlongGivesThePositionsThatAnAdvanceEndsAt) {
  const v1::Scene scene = make_scene();
  Watcher watcher = client.watch(scene.scene_id(), {.meshes = {0}});
  FrameStream stream = client.stream(scene, kOverGrpc);
  run(stream, 1, positions_at(1)).check();
  watcher.receive();
  std::vector<double> x, target;
  for (const auto& p : positions_at(1)) x.insert(x.end(), p.begin(), p.end());
  for (const auto& p : positions_at(-1.1)) target.insert(target.end(), p.begin(), p.end());
  const FrameUpdate update{.mesh = 0, .positions = std::as_bytes(std::span(target))};
  stream.send(2, {&update, 1}, {.advance = true});
  const FrameOutput step = stream.receive();
  step.check();
  EXPECT_GT(step.done.advanced(), 0.4);
  EXPECT_LT(step.done.advanced(), step.done.earliest_toi());
  move_along(std::span(x), std::span<const double>(target), step.done.advanced());
  const std::string bytes(reinterpret_cast<const char*>(x.data()), x.size() * sizeof(double));
  EXPECT_TRUE(watcher.receive().positions.at(0).positions() == bytes);
  expect_error(grpc::INVALID_ARGUMENT, [&] { move_along(std::span(x), std::span<const double>(target), 1.5); });
  expect_error(grpc::INVALID_ARGUMENT,
               [&] { move_along(std::span(x), std::span<const double>(target).first(3), 0.5); });
}

/// The tip of a triangle is pressed onto a floor, its two other corners stay above it, and a third mesh is far away.
class PressedVertex : public ClientAndDaemon {
 protected:
  static constexpr uint32_t kTip = 3;             // scene-wide
  static constexpr double kSeparation = 0x1p-28;  // 2^-32 of the scene's size, 9.5 rounded up to 16

  PressedVertex() {
    v1::SceneSpec spec;
    spec.set_mode(v1::DETECTION_MODE_CCD);
    spec.set_position_format(v1::POSITION_FORMAT_F64);
    const std::vector<MeshInput> meshes{{.name = "floor", .vertex_count = 3, .triangles = kOne, .is_static = true},
                                        {.name = "tip", .vertex_count = 3, .triangles = kOne},
                                        {.name = "free", .vertex_count = 3, .triangles = kOne}};
    scene = client.create_scene(spec, meshes);
  }

  /// Steps with that mode, and compares the positions that the client computes with the daemon's.
  FrameOutput step(const StreamOptions& options, v1::AdvanceMode mode) {
    Watcher watcher = client.watch(scene.scene_id(), {.meshes = {1, 2}});
    FrameStream stream = client.stream(scene, options);
    const uint64_t first = stream.scene().last_frame_id() + 1;
    std::vector<double> tip{1, 1, 1, 1.5, 1, 3, 1, 1.5, 3}, free{9, 9, 0, 9.5, 9, 0, 9, 9.5, 0};
    const std::vector<double> floor{0, 0, 0, 4, 0, 0, 0, 4, 0}, tip_end{1, 1, -1.1, 1.6, 1, 1.3, 1, 1.6, 1.2},
        free_end{9, 9, 3.1, 9.5, 9.3, 3, 9, 9.5, 3};
    const auto send = [&](uint64_t id, const std::vector<double>& a, const std::vector<double>& b,
                          const FrameOptions& frame) {
      std::vector<FrameUpdate> updates{{.mesh = 1, .positions = std::as_bytes(std::span(a))},
                                       {.mesh = 2, .positions = std::as_bytes(std::span(b))}};
      if (id == 1) updates.push_back({.mesh = 0, .positions = std::as_bytes(std::span(floor))});
      stream.send(id, updates, frame);
      FrameOutput output = stream.receive();
      output.check();
      return output;
    };
    send(first, tip, free, {.accuracy = v1::ACCURACY_CANDIDATES});
    watcher.receive();
    FrameOutput output = send(first + 1, tip_end, free_end, {.advance = true, .advance_mode = mode, .limits = true});
    move_along(std::span(tip), std::span<const double>(tip_end), output.advance, 1, 3);
    move_along(std::span(free), std::span<const double>(free_end), output.advance, 2, 6);
    const WatchedFrame shown = watcher.receive();
    const auto expect_at = [&](size_t mesh, const std::vector<double>& x) {
      const std::string bytes(reinterpret_cast<const char*>(x.data()), x.size() * sizeof(double));
      EXPECT_TRUE(shown.positions.at(mesh).positions() == bytes) << mesh << " at mode " << mode;
    };
    expect_at(0, tip);
    expect_at(1, free);
    EXPECT_EQ(shown.done.way(), output.done.way());
    EXPECT_FALSE(shown.done.has_shortened());
    EXPECT_EQ(shown.done.limits_size(), 0);
    stream.finish();
    return output;
  }
  /// The pressed vertex comes to the floor, and so does what hangs on it.
  static void expect_limits(const FrameOutput& output) {
    const Contacts& limits = output.limits.vertex_triangle;
    ASSERT_EQ(limits.count, 1u);
    EXPECT_EQ(limits.elements[0], (std::array<uint32_t, 2>{kTip, 0}));
    EXPECT_EQ(limits.stencils[0], (std::array<uint32_t, 4>{kTip, 0, 1, 2}));
    EXPECT_EQ(limits.distance[0], kSeparation);
    EXPECT_NEAR(limits.toi[0], (1 - kSeparation) / 2.1, 1e-9);
    EXPECT_LE(limits.toi[0], (1 - kSeparation) / 2.1);
    EXPECT_NEAR(limits.weights[0][0], 0.25, 1e-9);
    EXPECT_EQ(limits.normals[0], (std::array<float, 3>{0, 0, 1}));
    EXPECT_EQ(limits.flags[0], v1::CONTACT_FLAG_CERTIFIED);
    EXPECT_EQ(output.limits.edge_edge.count, 0u);
    EXPECT_EQ(output.done.limits_size(), 0);
  }

  const Triangles kOne{{0, 1, 2}};
  v1::Scene scene;
};

TEST_F(PressedVertex, AloneIsShortenedOnEveryTransport) {
  for (const Local local : {Local::kOff, Local::kOn}) {
    const FrameOutput output = step({.local = {.use = local}}, v1::ADVANCE_MODE_PER_VERTEX);
    ASSERT_EQ(output.advance.ids, std::vector<uint32_t>{kTip});
    expect_limits(output);
    EXPECT_EQ(output.advance.fractions[0], output.done.advanced());
    EXPECT_GT(output.done.advanced(), 0.4);
    EXPECT_LT(output.done.advanced(), output.done.earliest_toi());
    EXPECT_GT(output.done.way(), 0.8);
    EXPECT_LT(output.done.way(), 1);
  }
}

TEST_F(PressedVertex, ShortensItsMeshOrTheSceneInOtherModes) {
  const FrameOutput mesh = step(kOverGrpc, v1::ADVANCE_MODE_PER_MESH);
  EXPECT_EQ(mesh.advance.ids, std::vector<uint32_t>{1});
  expect_limits(mesh);
  EXPECT_EQ(mesh.advance.of_vertex(1, kTip + 1), mesh.done.advanced());
  EXPECT_EQ(mesh.advance.of_vertex(2, 6), 1);
  for (const auto mode : {v1::ADVANCE_MODE_UNSPECIFIED, v1::ADVANCE_MODE_ALL_OR_ONE}) {
    const FrameOutput all = step(kOverGrpc, mode);
    EXPECT_TRUE(all.advance.ids.empty());
    expect_limits(all);
    EXPECT_LT(all.done.way(), mesh.done.way());
    EXPECT_NEAR(all.done.way(), all.done.advanced(), 1e-6);
  }
}

TEST_F(ClientAndDaemon, PoseAlongGivesThePoseThatAnAdvanceEndsAt) {
  const Triangles one{{0, 1, 2}}, sides{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  spec.set_min_separation(0.01);
  const std::vector<MeshInput> meshes{{.name = "floor", .vertex_count = 3, .triangles = one, .is_static = true},
                                      {.name = "body", .vertex_count = 4, .triangles = sides, .is_rigid = true}};
  const v1::Scene scene = client.create_scene(spec, meshes);
  Watcher watcher = client.watch(scene.scene_id(), {.meshes = {1}});
  FrameStream stream = client.stream(scene, kOverGrpc);
  const std::vector<double> floor{0, 0, 0, 4, 0, 0, 0, 4, 0}, body{0.9, 0.9, 1, 1.4, 1, 1.1, 1, 1.3, 1.2, 1.1, 1, 1.6};
  const std::vector<FrameUpdate> first{{.mesh = 0, .positions = std::as_bytes(std::span(floor))},
                                       {.mesh = 1, .positions = std::as_bytes(std::span(body))}};
  stream.send(1, first);
  stream.receive().check();
  watcher.receive();
  RigidMatrix pose{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::vector<double> went;
  for (uint64_t step = 1; step <= 3; ++step) {
    // About a line through (1, 1, 1), and down: at first to above the floor, and then through it.
    const double angle = 0.9 * static_cast<double>(step), c = std::cos(angle), s = std::sin(angle);
    const RigidMatrix target{1, 0, 0, 0, 0, c, -s, 1 - c + s, 0, s, c, 1 - c - s - (step == 1 ? 0.4 : 1.9)};
    const FrameUpdate turn{.mesh = 1, .transform = &target};
    stream.send(step + 1, {&turn, 1}, {.advance = true, .advance_mode = v1::ADVANCE_MODE_PER_MESH});
    const FrameOutput output = stream.receive();
    output.check();
    went.push_back(output.advance.of_body(1, 3, 4));
    pose = pose_along(pose, target, went.back());
    std::vector<double> x = body;
    move_rigidly(std::span(x), pose);
    const std::string bytes(reinterpret_cast<const char*>(x.data()), x.size() * sizeof(double));
    EXPECT_TRUE(watcher.receive().positions.at(0).positions() == bytes) << "step " << step << ", " << went.back();
  }
  EXPECT_GT(went[1], 0);
  EXPECT_LT(went[1], 1);
}

TEST_F(ClientAndDaemon, AWatcherIsCancelledWhileItWaits) {
  const v1::Scene scene = make_scene();
  Watcher watcher = client.watch(scene.scene_id());
  std::thread other([&] { watcher.cancel(); });
  expect_error(grpc::CANCELLED, [&] { watcher.receive(); });
  other.join();
  expect_error(grpc::INVALID_ARGUMENT, [&] { client.watch(scene.scene_id(), {.max_contacts_per_kind = 1u << 30}); });
}

TEST_F(ClientAndDaemon, ARefusedFrameIsAnAnswerAndTheStreamGoesOn) {
  const v1::Scene scene = make_scene();
  FrameStream stream = client.stream(scene, {.window = 1, .local = kOverGrpc.local});
  run(stream, 1, positions_at(1)).check();
  auto bad = positions_at(-1);
  bad[3][2] = NAN;
  const FrameOutput refused = run(stream, 2, bad);
  EXPECT_THROW(refused.check(), Error);
  EXPECT_EQ(run(stream, 3, positions_at(-1)).vertex_triangle.count, 1u);
  stream.finish();
}

/// The flags of the one vertex-triangle contact from a start at which the corner is `height` above.
uint8_t flags_from(Client& client, const v1::Scene& scene, double height) {
  FrameStream stream = client.stream(scene, kOverGrpc);
  v1::Frame frame;
  frame.set_frame_id(stream.scene().last_frame_id() + 1);
  *frame.add_updates() = mesh_update(0, v1::POSITION_FORMAT_F64, positions_at(-1), positions_at(height));
  stream.send(frame);
  const FrameOutput output = stream.receive();
  output.check();
  stream.finish();
  return output.vertex_triangle.flags.at(0);
}

TEST_F(ClientAndDaemon, TheFlagsOfAContactAreMasks) {
  const v1::Scene scene = make_scene();
  const uint8_t touching = flags_from(client, scene, 0), apart = flags_from(client, scene, 1);
  EXPECT_TRUE(touching & v1::CONTACT_FLAG_INITIAL);
  EXPECT_FALSE(apart & v1::CONTACT_FLAG_INITIAL);
  EXPECT_TRUE(apart & v1::CONTACT_FLAG_CERTIFIED);
  EXPECT_FALSE((apart | touching) & v1::CONTACT_FLAG_CAPPED);
}

TEST_F(ClientAndDaemon, AThreadCanReceiveBeforeTheFirstFrameIsSent) {
  FrameStream stream = client.stream(make_scene(), kOverGrpc);
  EXPECT_THROW(stream.receive(), Error);
  EXPECT_FALSE(stream.receive_within(std::chrono::milliseconds(0)));
  std::vector<uint64_t> received;
  std::optional<Error> end;
  std::thread receiver([&] {
    try {
      for (;;)
        if (const auto output = stream.receive_within(std::chrono::milliseconds(10)))
          received.push_back(output->frame_id);
    } catch (const Error& e) {
      end = e;
    }
  });
  for (uint64_t id = 1; id <= 5; ++id) {
    const auto positions = positions_at(1);
    const FrameUpdate update{.positions = std::as_bytes(std::span(positions))};
    stream.send(id, {&update, 1});
  }
  stream.finish();
  receiver.join();
  EXPECT_EQ(received, (std::vector<uint64_t>{1, 2, 3, 4, 5}));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code(), grpc::FAILED_PRECONDITION) << end->what();
}

TEST_F(ClientAndDaemon, AMessageAboveTheLimitIsNotSentAndCostsNoCredit) {
  FrameStream stream = stream_of(make_scene(), 200);
  const std::vector<std::array<double, 3>> many(100);
  for (int i = 0; i < 5; ++i) {
    try {
      run(stream, 1, many);
      FAIL();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), grpc::RESOURCE_EXHAUSTED);
      EXPECT_NE(e.message().find("limit is 200"), std::string::npos);
    }
  }
  run(stream, 1, positions_at(1)).check();
  stream.finish();
}

TEST_F(ClientAndDaemon, AFrameOfManyMegabytesIsSentWhole) {
  const uint32_t count = 500'000;
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_DCD);
  spec.set_thickness(0.1);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  const MeshInput mesh{.name = "two of many", .vertex_count = count, .triangles = kTriangles};
  const v1::Scene scene = client.create_scene(spec, {&mesh, 1});
  FrameStream stream = client.stream(scene, kOverGrpc);
  std::vector<std::array<double, 3>> positions(count, {9, 9, 9});
  const auto near = positions_at(0.05);
  std::copy(near.begin(), near.end(), positions.begin());
  EXPECT_EQ(run(stream, 1, positions).vertex_triangle.count, 1u);
  positions.back()[1] = INFINITY;  // the last bytes arrive, too
  EXPECT_THROW(run(stream, 2, positions).check(), Error);
  stream.finish();
}

TEST_F(ClientAndDaemon, AStreamThatIsLetGoOfIsCancelled) {
  const v1::Scene scene = make_scene();
  {
    FrameStream stream = client.stream(scene, kOverGrpc);
    run(stream, 1, positions_at(1));
  }
  client.delete_scene(scene.scene_id());
  try {
    client.stream(scene, kOverGrpc);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), grpc::NOT_FOUND);
  }
}

TEST_F(ClientAndDaemon, AStoppingDaemonSaysSoBeforeTheConnectionIsLost) {
  FrameStream stream = client.stream(make_scene(), kOverGrpc);
  run(stream, 1, positions_at(1)).check();
  std::thread stop([&] { daemon.reset(); });
  while (!stream.draining_deadline()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  try {
    for (uint64_t id = 2;; ++id) run(stream, id, positions_at(1)).check();
  } catch (const Error& e) {
    EXPECT_TRUE(is_connection_lost(e)) << e.what();
  }
  stop.join();
  EXPECT_THROW(stream.finish(), Error);
}

}  // namespace
}  // namespace collided::client
