// Answers of a local stream as packets: what the engine found is in them, however long it is.
#include "server/transport/local/encode.hpp"

#include <gtest/gtest.h>

#include "proto/constants.hpp"
#include "server/convert/mesh_pairs.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

pb::StreamFramesResponse parse(const std::string& packet) {
  EXPECT_LE(packet.size(), pb::kMaxPacketBytes);
  pb::LocalResponse response;
  EXPECT_TRUE(response.ParseFromString(packet));
  return response.frame();
}

AnsweredFrame frame_with(uint32_t shortened, uint32_t contacts) {
  AnsweredFrame frame{7, std::chrono::steady_clock::now(), {}, {}, false};
  for (uint32_t i = 0; i < shortened; ++i) {
    frame.result.shortened.ids.push_back(2 * i);
    frame.result.shortened.fractions.push_back(1 / (i + 2.0));
  }
  frame.result.vertex_triangle.elements = std::vector<std::array<uint32_t, 2>>(contacts, {3, 0});
  frame.result.vertex_triangle.toi = std::vector<double>(contacts, 0.5);
  return frame;
}

// A million vertices take 12 MB, and a packet has 64 KiB.
TEST(LocalAnswer, ShortenedWaysTakeAsManyPacketsAsTheyNeed) {
  SceneBench bench;
  const SceneUse scene = bench.add();
  for (const uint32_t count : {0u, 1u, 100u, 4096u, 4097u, 8192u, 1'000'000u})
    for (const uint32_t hits : {0u, 1u, 5000u}) {
      AnsweredFrame frame = frame_with(count, hits);
      std::string ids, fractions;
      uint64_t contacts = 0;
      const std::vector<std::string> packets = AnswerWriter(nullptr, 2).write(*scene, frame);
      for (const std::string& packet : packets) {
        const pb::StreamFramesResponse response = parse(packet);
        EXPECT_EQ(response.frame_id(), 7u);
        EXPECT_EQ(response.has_done(), &packet == &packets.back());
        ids += response.shortened().ids() + response.done().shortened().ids();
        fractions += response.shortened().fractions() + response.done().shortened().fractions();
        contacts += response.contacts().count();
        for (const pb::ContactChunk& chunk : response.done().contacts()) contacts += chunk.count();
      }
      const ShortenedWays& ways = frame.result.shortened;
      EXPECT_EQ(packets.size() == 1, count <= 100 && hits <= 1) << count << " " << hits;
      EXPECT_EQ(ids, std::string(reinterpret_cast<const char*>(ways.ids.data()), 4 * size_t{count}));
      EXPECT_EQ(fractions, std::string(reinterpret_cast<const char*>(ways.fractions.data()), 8 * size_t{count}));
      EXPECT_EQ(contacts, hits);
    }
}

TEST(LocalAnswer, LimitsTakeAsManyPacketsAsTheyNeed) {
  SceneBench bench;
  const SceneUse scene = bench.add();
  for (const uint32_t count : {0u, 1u, 100u, 5000u, 100'000u}) {
    AnsweredFrame frame = frame_with(count, 10);
    ContactSet& limits = frame.result.limits.vertex_triangle;
    limits.elements = std::vector<std::array<uint32_t, 2>>(count, {3, 0});
    std::vector<double> toi;
    for (uint32_t i = 0; i < count; ++i) toi.push_back(1 / (i + 2.0));
    limits.toi = limits.distance = Column<double>(toi);
    limits.weights = std::vector<std::array<double, 2>>(count), limits.normals = std::vector<Normal>(count);
    limits.flags = std::vector<uint8_t>(count, 1);
    std::string came;
    uint64_t stencils = 0;
    const auto take = [&](const pb::ContactChunk& chunk) {
      EXPECT_FALSE(chunk.has_shared());
      came += chunk.toi(), stencils += chunk.stencils().size() / 16;
    };
    for (const std::string& packet : AnswerWriter(nullptr, 2).write(*scene, frame)) {
      const pb::StreamFramesResponse response = parse(packet);
      if (response.has_limits()) take(response.limits());
      for (const pb::ContactChunk& chunk : response.done().limits()) take(chunk);
    }
    EXPECT_EQ(came, std::string(reinterpret_cast<const char*>(toi.data()), 8 * size_t{count}));
    EXPECT_EQ(stencils, count);
  }
}

TEST(LocalAnswer, PairsOfMeshesTakeAsManyPacketsAsTheyNeed) {
  SceneBench bench;
  const SceneUse scene = bench.add();
  for (const uint32_t count : {0u, 1u, 100u, 1694u, 1695u, 3388u, 100'000u})
    for (const uint32_t hits : {0u, 1u, 5000u}) {
      AnsweredFrame frame = frame_with(0, hits);
      for (uint32_t i = 0; i < count; ++i)
        frame.result.pair_states.push_back({.first = i, .second = i + 1, .deepest = 2 * i});
      pb::MeshPairs expected;
      fill_pairs(frame.result.pair_states, &expected);
      std::string meshes, deepest;
      uint64_t contacts = 0;
      const std::vector<std::string> packets = AnswerWriter(nullptr, 2).write(*scene, frame);
      for (const std::string& packet : packets) {
        const pb::StreamFramesResponse response = parse(packet);
        meshes += response.pairs().meshes() + response.done().pairs().meshes();
        deepest += response.pairs().deepest() + response.done().pairs().deepest();
        contacts += response.contacts().count();
        for (const pb::ContactChunk& chunk : response.done().contacts()) contacts += chunk.count();
      }
      EXPECT_EQ(packets.size() == 1, hits <= 1 && count <= (hits == 0 ? 1694u : 100u)) << count << " " << hits;
      EXPECT_EQ(meshes, expected.meshes());
      EXPECT_EQ(deepest, expected.deepest());
      EXPECT_EQ(contacts, hits);
    }
}

}  // namespace
}  // namespace collided::server
