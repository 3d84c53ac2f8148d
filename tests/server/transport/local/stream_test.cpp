// Frames over the local socket: the answers are those of gRPC, wherever their arrays are.
#include <gtest/gtest.h>

#include <limits>

#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

using test::first_frame;
using test::tip_frame;

class LocalFrames : public testing::Test {
 protected:
  Serving serving_;
};

// `count` tips in one mesh, all of which meet the floor at t = 1/2.
pb::CreateSceneRequest tips_request(uint32_t count) {
  auto request = test::tip_request();
  auto* tips = request.mutable_spec()->mutable_meshes(1);
  std::vector<uint32_t> corners;
  for (uint32_t i = 0; i < 3 * count; ++i) corners.push_back(i);
  tips->set_vertex_count(3 * count);
  tips->set_triangles(test::pack(corners));
  tips->set_no_self_contacts(true);
  return request;
}

pb::Frame tips_frame(uint64_t id, uint32_t count) {
  test::Points start, end;
  for (uint32_t i = 0; i < count; ++i) {
    const double shift = 0.001 * i / count;
    for (auto point : test::tip_points(1)) start.push_back({point[0] + shift, point[1], point[2]});
    for (auto point : test::tip_points(-1)) end.push_back({point[0] + shift, point[1], point[2]});
  }
  auto frame = id == 1 ? first_frame(2) : tip_frame(id, 2);
  frame.mutable_updates(0)->set_start_positions(test::pack_points(start, false));
  frame.mutable_updates(0)->set_positions(test::pack_points(end, false));
  return frame;
}

std::string joined(const test::Answer& answer, const std::string& (pb::ContactChunk::*field)() const) {
  std::string all;
  for (const auto& chunk : answer.chunks) all += (chunk.*field)();
  return all;
}

TEST_F(LocalFrames, TenFramesInSharedMemory) {
  for (const bool wide : {false, true}) {
    LocalStream stream(serving_.path(), serving_.make_scene(test::tip_request(wide)));
    ASSERT_TRUE(stream.opened());
    for (int i = 0; i < 10; ++i) {
      const double depth = 1.25 + 0.25 * i;
      test::expect_tip_contact(stream.ask_shared(i == 0 ? first_frame(depth, wide) : tip_frame(i + 1, depth, wide)),
                               depth);
    }
    EXPECT_EQ(stream.shared_chunks(), 10u);
    stream.raw().half_close();
    EXPECT_EQ(stream.raw().closed().code(), 0);
  }
}

TEST_F(LocalFrames, EverythingInPackets) {
  const RawLocal raw(serving_.path());
  const std::string scene = serving_.make_scene();
  raw.send(test::open_request(scene, 0, 0));
  ASSERT_TRUE(raw.receive());
  raw.send(first_frame(2));
  const auto done = raw.receive();
  ASSERT_TRUE(done && done->frame().done().contacts_size() == 1);
  EXPECT_FALSE(done->frame().done().contacts(0).has_shared());
  test::expect_tip_contact({done->frame().done().contacts(0)}, done->frame().done(), 2);
  pb::Frame shared = tip_frame(2, 2);
  shared.mutable_updates(0)->clear_positions();
  shared.mutable_updates(0)->mutable_shared_positions()->set_size(36);
  raw.send(shared);
  const auto refused = raw.receive();
  ASSERT_TRUE(refused && refused->frame().has_error());
  EXPECT_EQ(refused->frame().error().field(), "frame.updates[0].shared_positions");
}

// The output region holds some of the contacts, half of a chunk, or none: all arrive, in the same order.
TEST_F(LocalFrames, NoContactIsDroppedWhereTheRegionIsSmall) {
  constexpr uint32_t kTips = 2000;  // 80 KiB of contacts
  const std::string scene = serving_.make_scene(tips_request(kTips));
  std::vector<test::Answer> answers;
  for (const size_t output : {4 << 20, 0, 4096, 8192, 64 << 10, 128 << 10}) {
    LocalStream stream(serving_.path(), scene, {.output = output});
    ASSERT_TRUE(eventually([&] { return stream.opened().has_value(); }));
    const uint64_t id = stream.opened()->scene().last_frame_id() + 1;
    answers.push_back(stream.ask(test::shared_frame(tips_frame(id, kTips), stream.memory())));
    const auto& answer = answers.back();
    ASSERT_TRUE(answer.done) << output;
    EXPECT_GE(answer.done->contact_count(), kTips);
    uint64_t count = 0;
    for (const auto& chunk : answer.chunks) count += chunk.count();
    EXPECT_EQ(count, answer.done->contact_count()) << output;
    for (const auto field : {&pb::ContactChunk::elements, &pb::ContactChunk::stencils, &pb::ContactChunk::toi,
                             &pb::ContactChunk::distance, &pb::ContactChunk::flags})
      EXPECT_EQ(joined(answer, field), joined(answers.front(), field)) << output;
    EXPECT_EQ(stream.shared_chunks() > 0, output >= 8192) << output;
    stream.raw().hang_up();
    ASSERT_TRUE(eventually([&] { return serving_.server().connections() == 0; }));
  }
  EXPECT_EQ(answers[0].chunks.size(), 1u);
  EXPECT_GT(answers[1].chunks.size(), 1u);
}

TEST_F(LocalFrames, BadRangesAreRefusedAndTheStreamGoesOn) {
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
  LocalStream stream(serving_.path(), serving_.make_scene());
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  const std::pair<uint64_t, uint64_t> bad[] = {{test::LocalSizes::kInput, 36},
                                               {test::LocalSizes::kInput - 32, 36},
                                               {kMost, 36},
                                               {kMost - 35, 36},
                                               {0, kMost},
                                               {0, test::LocalSizes::kInput + 8},
                                               {4, 36},
                                               {0, 24},
                                               {0, 48},
                                               {0, 37},
                                               {0, 0}};
  uint64_t id = 2;
  for (const auto& [offset, size] : bad) {
    pb::Frame frame = test::shared_frame(tip_frame(id++, 3), stream.memory());
    frame.mutable_updates(0)->mutable_shared_positions()->set_offset(offset);
    frame.mutable_updates(0)->mutable_shared_positions()->set_size(size);
    const auto answer = stream.ask(frame);
    ASSERT_TRUE(answer.error) << offset << " " << size;
    EXPECT_EQ(answer.error->code(), 3) << answer.error->message();
    EXPECT_TRUE(answer.error->field().starts_with("frame.updates[0]")) << answer.error->field();
  }
  pb::Frame both = test::shared_frame(tip_frame(id++, 3), stream.memory());
  both.mutable_updates(0)->set_positions("too");
  EXPECT_TRUE(stream.ask(both).error);
  test::expect_tip_contact(stream.ask_shared(tip_frame(id, 2.5)), 2.5);
}

TEST_F(LocalFrames, RefusalsComeInTheirTurn) {
  LocalStream stream(serving_.path(), serving_.make_scene(), {.window = 4});
  stream.raw().send(test::shared_frame(first_frame(2), stream.memory()));
  pb::Frame nan = tip_frame(2, 2);
  nan.mutable_updates(0)->set_positions(test::pack(std::vector<float>(9, std::numeric_limits<float>::quiet_NaN())));
  stream.raw().send(test::shared_frame(nan, stream.memory(), 1024));
  stream.raw().send(test::shared_frame(tip_frame(1, 2), stream.memory(), 2048));
  stream.raw().send(test::shared_frame(tip_frame(4, 3), stream.memory(), 3072));
  stream.raw().half_close();
  test::expect_tip_contact(stream.receive(1), 2);
  EXPECT_EQ(stream.receive(2).error->field(), "frame.updates[0].positions");
  EXPECT_EQ(stream.receive(1).error->code(), 9);
  test::expect_tip_contact(stream.receive(4), 3);
  EXPECT_EQ(stream.raw().closed().code(), 0);
}

TEST_F(LocalFrames, SparseIndicesAndTheMessageItselfCanBeShared) {
  LocalStream stream(serving_.path(), serving_.make_scene());
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  pb::Frame sparse;
  sparse.set_frame_id(2);
  auto* update = sparse.add_updates();
  update->set_mesh(1);
  update->set_start_positions(test::pack_points({test::tip_points(1)[0]}, false));
  update->set_positions(test::pack_points({test::tip_points(-2)[0]}, false));
  sparse = test::shared_frame(sparse, stream.memory());
  stream.memory().put(4096, test::pack<uint32_t>({0}));
  sparse.mutable_updates(0)->mutable_sparse()->mutable_shared_indices()->set_offset(4096);
  sparse.mutable_updates(0)->mutable_sparse()->mutable_shared_indices()->set_size(4);
  test::expect_tip_contact(stream.ask(sparse), 3);
  const std::string message = test::shared_frame(tip_frame(3, 4), stream.memory()).SerializeAsString();
  stream.memory().put(8192, message);
  pb::LocalRequest request;
  request.mutable_shared_frame()->set_offset(8192);
  request.mutable_shared_frame()->set_size(message.size());
  stream.raw().send(request);
  test::expect_tip_contact(stream.receive(3), 4);
  stream.memory().put(8192, "\xff\xff\xff\xff");
  stream.raw().send(request);
  EXPECT_EQ(stream.raw().closed().field(), "shared_frame");
}

TEST_F(LocalFrames, AStreamEndsWithItsScene) {
  const std::string scene = serving_.make_scene();
  LocalStream stream(serving_.path(), scene);
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  serving_.host().scenes().remove(serving_.client(), scene);
  EXPECT_EQ(stream.raw().closed().code(), 5);
}

TEST_F(LocalFrames, AStreamIsToldOfTheStop) {
  LocalStream stream(serving_.path(), serving_.make_scene());
  ASSERT_TRUE(stream.opened());
  const RawLocal late(serving_.path());
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  serving_.host().announce_stop(3);
  const auto draining = stream.raw().receive();
  ASSERT_TRUE(draining && draining->frame().has_draining());
  EXPECT_EQ(draining->frame().draining().deadline_seconds(), 3);
  test::expect_tip_contact(stream.ask_shared(tip_frame(2, 3)), 3);
  late.send(test::open_request("any", 0, 0));
  EXPECT_EQ(late.closed().code(), 14);
  serving_.server().stop();
  EXPECT_EQ(stream.raw().closed().code(), 14);
  EXPECT_FALSE(std::filesystem::exists(serving_.path()));
}

TEST_F(LocalFrames, FramesAreCountedAgainstTheRate) {
  Config config = Serving::cpu_config();
  config.limits.client.max_frames_per_second = 0.01;
  Serving slow({}, config);
  LocalStream stream(slow.path(), slow.make_scene());
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  const auto answer = stream.ask_shared(tip_frame(2, 2));
  ASSERT_TRUE(answer.error);
  EXPECT_EQ(answer.error->code(), 8);
  EXPECT_GT(answer.error->retry_after_seconds(), 0);
}

TEST_F(LocalFrames, AreMeasuredAsThoseOfGrpc) {
  LocalStream stream(serving_.path(), serving_.make_scene());
  const auto answer = stream.ask_shared(first_frame(2));
  ASSERT_TRUE(answer.done);
  const auto& metrics = answer.done->metrics();
  EXPECT_EQ(metrics.bytes_in(), 3u * 36);
  EXPECT_GT(metrics.bytes_out(), 0u);
  EXPECT_GT(metrics.total_milliseconds(), 0);
  EXPECT_NE(serving_.metrics().text().find("frames"), std::string::npos);
}

}  // namespace
}  // namespace collided::server
