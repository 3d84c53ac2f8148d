// Frames of a set over streams, with shared memory and without, beside the same in calls.

#include <numeric>

#include "client/cpp/batch/scene_set.hpp"
#include "client/in_process/local.hpp"
#include "tests/integration/batch/tip_set.hpp"
#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {
namespace {

using client::FrameUpdate;
using client::Local;
using client::SceneSet;
using client::SetOutput;
using client::SetUpdate;

constexpr uint32_t kManyWorlds = 700;
const std::vector<std::array<uint32_t, 3>> kTriangle{{0, 1, 2}};

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

SetUpdate update_of(const Falls& falls, std::span<const uint32_t> worlds = {}) {
  return {.positions = bytes_of(falls.end), .start_positions = bytes_of(falls.start), .worlds = worlds};
}

void expect_same(const client::WorldContacts& a, const client::WorldContacts& b) {
  EXPECT_EQ(a.begin, b.begin);
  EXPECT_EQ(a.count, b.count);
  EXPECT_EQ(a.elements, b.elements);
  EXPECT_EQ(a.stencils, b.stencils);
  EXPECT_EQ(a.toi, b.toi);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.weights, b.weights);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.flags, b.flags);
  EXPECT_EQ(a.features, b.features);
  EXPECT_EQ(a.signed_distances, b.signed_distances);
}

class SetStreams : public testing::Test {
 protected:
  SceneSet make(uint32_t count, Local use, uint64_t output_bytes = 1 << 20) {
    return make(client_, count, {.use = use, .output_bytes = output_bytes});
  }
  static SceneSet make(client::Client& client, uint32_t count, const client::LocalOptions& local = {}) {
    pb::SceneSpec spec = tip_request().spec();
    spec.clear_meshes();
    const client::MeshInput meshes[] = {{.name = "floor", .vertex_count = 3, .triangles = kTriangle, .is_static = true},
                                        {.name = "tip", .vertex_count = 3, .triangles = kTriangle}};
    return SceneSet::create(client, spec, meshes, count, {.local = local});
  }

  OpenFolder folder_;
  DaemonProcess daemon_{{"--local-socket", folder_.file("local")}};
  client::Client client_ = client::Client::connect(daemon_.address());
};

// More numbers than there are fields in a message of a scene.
TEST_F(SetStreams, MayNameEveryWorld) {
  constexpr uint32_t kWorlds = 3000;
  std::vector<uint32_t> worlds(kWorlds);
  std::iota(worlds.begin(), worlds.end(), 0u);
  for (const Local use : {Local::kOff, Local::kOn}) {
    SceneSet set = make(kWorlds, use);
    const Falls all = falls(std::vector<double>(kWorlds, 2), true);
    const SetOutput output = set.detect(update_of(all, worlds));
    output.check();
    EXPECT_EQ(output.done.contact_count(), kWorlds);
  }
}

// Also of the engine in this process: of every world, of some, without starts, and with more contacts than the memory
// for them has room for.
TEST_F(SetStreams, AnswerWithTheSameBytesAsCalls) {
  SceneSet call = make(kManyWorlds, Local::kOff), remote = make(kManyWorlds, Local::kOff),
           local = make(kManyWorlds, Local::kOn), tight = make(kManyWorlds, Local::kOn, 4096);
  client::Client in_process = collided::local({.backend = test_backend()});
  SceneSet here = make(in_process, kManyWorlds);
  const auto step = [&](const SetUpdate& update, uint64_t expected) {
    const client::SetStep steps[] = {{&call, update}};
    const SetOutput wanted = std::move(client::detect_batch(steps)[0]);
    wanted.check();
    EXPECT_EQ(wanted.done.contact_count(), expected);
    for (SceneSet* const set : {&remote, &local, &tight, &here}) {
      const SetOutput output = set->detect(update);
      expect_same(output.vertex_triangle, wanted.vertex_triangle);
      expect_same(output.edge_edge, wanted.edge_edge);
      expect_same(output.triangle_triangle, wanted.triangle_triangle);
      EXPECT_EQ(output.done.contact_count(), expected);
      EXPECT_EQ(output.done.earliest_toi(), wanted.done.earliest_toi());
    }
  };
  std::vector<double> depths;
  uint64_t hits = 0;
  for (uint32_t world = 0; world < kManyWorlds; ++world) {
    depths.push_back(0.5 + world % 4);
    hits += depths.back() > 1 ? 1 : 0;
  }
  step(update_of(falls(depths, true)), hits);
  step(update_of(falls(depths, false)), hits);
  const Falls up = falls(std::vector<double>(kManyWorlds, 0.0), false);
  step({.positions = bytes_of(up.end)}, hits);
  const uint32_t worlds[] = {0, 3, 4, 699};
  step(update_of(falls({2, 0.5, 4, 2}, false), worlds), 3);
  EXPECT_FALSE(remote.is_local());
  EXPECT_TRUE(local.is_local());
}

TEST_F(SetStreams, RefuseWorldsOneByOne) {
  for (const Local use : {Local::kOff, Local::kOn}) {
    SceneSet set = make(kManyWorlds, use);
    Falls first = falls(std::vector<double>(kManyWorlds, 2.0), true);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr size_t kWorldBytes = 6 * 3 * sizeof(float), kCoordinate = (9 + 4) * sizeof(float);
    for (size_t world = 1; world < kManyWorlds; ++world)
      std::memcpy(first.end.data() + world * kWorldBytes + kCoordinate, &nan, sizeof(nan));
    const SetOutput output = set.detect(update_of(first));
    EXPECT_EQ(output.vertex_triangle.count, 1u);
    ASSERT_EQ(output.refused.size(), kManyWorlds - 1);
    for (uint32_t i = 0; i + 1 < kManyWorlds; ++i) {
      EXPECT_EQ(output.refused[i].world(), i + 1);
      EXPECT_EQ(output.refused[i].error().code(), grpc::INVALID_ARGUMENT);
    }
    EXPECT_EQ(output.refused[0].error().field(), "frame.updates[0].positions");
    EXPECT_TRUE(output.refused[0].error().message().starts_with(
        "frame.updates[0].positions: world 1, mesh 1, vertex 1, coordinate y is nan"))
        << output.refused[0].error().message();
    EXPECT_FALSE(output.refused[255].error().message().empty());
    EXPECT_TRUE(output.refused[256].error().message().empty());
    const uint32_t good[] = {0};
    EXPECT_EQ(set.detect(update_of(falls({3}, false), good)).vertex_triangle.count, 1u);
  }
}

TEST_F(SetStreams, TakeAsManyFramesAheadAsTheWindowHas) {
  SceneSet set = make(3, Local::kOn);
  EXPECT_THROW(set.receive(), client::Error);
  set.send(update_of(falls({2, 0.5, 2}, true)));
  set.send(update_of(falls({0.5, 2, 0.5}, false)));
  EXPECT_THROW(set.detect(update_of(falls({2, 2, 2}, false))), client::Error) << "two answers are not received yet";
  EXPECT_EQ(set.receive().vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 1, 2}));
  EXPECT_EQ(set.receive().vertex_triangle.begin, (std::vector<uint64_t>{0, 0, 1, 1}));
  EXPECT_THROW(set.receive(), client::Error);
  const Falls in_place = falls({2, 2, 0.5}, false);
  const auto room = set.input(in_place.end.size());
  ASSERT_EQ(room.size(), in_place.end.size());
  std::memcpy(room.data(), in_place.end.data(), room.size());
  EXPECT_EQ(set.detect({.positions = room}).vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 1, 1}))
      << "the second one was below the floor";
}

TEST_F(SetStreams, AreOpenedAgainAfterTheyHaveEnded) {
  SceneSet set = make(2, Local::kOn);
  set.detect(update_of(falls({2, 0.5}, true)));
  { const client::FrameStream other = client_.resume(client_.get_scene(set.scene().scene_id())); }
  try {  // the end may be seen with this frame, or have been seen before
    set.detect(update_of(falls({2, 2}, false)));
  } catch (const client::Error& e) {
    EXPECT_EQ(e.code(), grpc::ABORTED) << e.message();
  }
  EXPECT_EQ(set.detect(update_of(falls({2, 0.5}, false))).vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 1}));
}

TEST_F(SetStreams, AreDoneWithoutWhereThereAreNone) {
  DaemonProcess daemon({"--max-streams", "1"});
  client_ = client::Client::connect(daemon.address());
  SceneSet other = make(1, Local::kOff), set = make(2, Local::kAutomatic);
  ASSERT_FALSE(other.is_local()) << "it has the one stream";
  EXPECT_EQ(set.detect(update_of(falls({2, 0.5}, true))).vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 1}));
  EXPECT_FALSE(set.is_local());
  EXPECT_TRUE(set.input(64).empty());
  EXPECT_THROW(set.detect(update_of(falls({2}, false))), client::Error);
}

TEST_F(SetStreams, BadFramesNameFieldValueAndLimit) {
  for (const Local use : {Local::kOff, Local::kOn}) {
    SceneSet set = make(3, use);
    client::FrameStream stream = client_.resume(set.scene(), {.local = {.use = use}});
    uint64_t id = 0;
    const auto ask = [&](const std::string& positions, const client::FrameOptions& options, uint32_t mesh = 0) {
      const FrameUpdate update{.mesh = mesh, .positions = bytes_of(positions)};
      stream.send(++id, {&update, 1}, options);
      return stream.receive();
    };
    const Falls good = falls({0, 0, 0}, true);
    const auto expect = [&](const std::string& field, const std::string& part, const client::FrameOutput& output) {
      ASSERT_TRUE(output.error) << field;
      EXPECT_EQ(output.error->field(), field) << output.error->message();
      EXPECT_NE(output.error->message().find(part), std::string::npos) << output.error->message();
    };
    expect("frame.updates[0].positions", "has 5 bytes; 3 worlds of 6 vertices, 12 bytes each, are 216",
           ask("12345", {}));
    expect("frame.worlds[1]", "is 1 after 2", ask(good.end, {.worlds = {2, 1}}));
    expect("frame.worlds[0]", "is 3, but the set has 3 worlds", ask(good.end, {.worlds = {3}}));
    expect("frame.meshes[0]", "is 2, but the set has 2 meshes", ask(good.end, {.meshes = {2}}));
    expect("frame.updates[0].mesh", "is 1, but must be 0", ask(good.end, {}, 1));
    expect("frame.advance", "is given", ask(good.end, {.advance = true}));
    expect("frame.advance_mode", "is given", ask(good.end, {.advance_mode = pb::ADVANCE_MODE_PER_MESH}));
    expect("frame.limits", "is given", ask(good.end, {.limits = true}));
    expect("frame.trial", "is given", ask(good.end, {.trial = true}));
    expect("frame.edit", "is given", ask(good.end, {.edit = pb::SceneEdit()}));
    stream.send(++id, {}, {});
    expect("frame.updates", "has 0 entries, but a set's frame has 1", stream.receive());
    EXPECT_FALSE(ask(good.end, {}).error);
    EXPECT_EQ(stream.scene().worlds(), 3u);
  }
}

TEST_F(SetStreams, ScenesOfTheirOwnHaveNoWorlds) {
  pb::SceneSpec spec = tip_request().spec();
  spec.clear_meshes();
  const client::MeshInput mesh{.name = "tip", .vertex_count = 3, .triangles = kTriangle};
  client::FrameStream stream = client_.stream(client_.create_scene(spec, {&mesh, 1}));
  const std::string positions = pack_points(tip_points(1));
  const FrameUpdate update{.positions = bytes_of(positions)};
  stream.send(1, {&update, 1}, {.worlds = {0}});
  const client::FrameOutput output = stream.receive();
  ASSERT_TRUE(output.error);
  EXPECT_EQ(output.error->field(), "frame.worlds");
}

}  // namespace
}  // namespace collided::test
