// Contacts cut into chunks, and the chunks as messages.
#include "server/convert/chunks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/support/every_field.hpp"

namespace collided::server {
namespace {

std::vector<pb::ContactChunk> messages(const FrameResult& result, const Topology& topology, const OutputFields& fields,
                                       size_t max_bytes) {
  std::vector<pb::ContactChunk> out;
  for (const Chunk& chunk : cut_into_chunks(result, fields, max_bytes))
    fill_chunk(chunk, topology, &out.emplace_back());
  return out;
}

size_t array_bytes(const pb::ContactChunk& chunk) {
  return chunk.elements().size() + chunk.stencils().size() + chunk.toi().size() + chunk.distance().size() +
         chunk.weights().size() + chunk.normals().size() + chunk.flags().size() + chunk.features().size() +
         chunk.signed_distances().size();
}

TEST(Chunks, ChunksAreBoundedAndCarryTheFieldsAskedFor) {
  FrameResult result;
  Topology topology;
  topology.triangles = {{0, 1, 2}};
  topology.edges = {{0, 1}, {3, 4}};
  result.vertex_triangle.elements = {{3, 0}, {4, 0}, {5, 0}, {6, 0}, {7, 0}};
  result.vertex_triangle.toi = {0, 0.1, 0.2, 0.3, 0.4};
  result.edge_edge.elements = {{0, 1}};
  result.edge_edge.toi = {0.5};
  const OutputFields fields{{ContactField::kToi}, true};
  const auto chunks = messages(result, topology, fields, 2 * fields.contact_bytes());
  ASSERT_EQ(chunks.size(), 4u);
  EXPECT_EQ(chunks[0].count(), 2u);
  EXPECT_EQ(chunks[2].count(), 1u);
  EXPECT_EQ(chunks[3].kind(), pb::CONTACT_KIND_EDGE_EDGE);
  EXPECT_TRUE(chunks[0].elements().empty());
  size_t bytes = 0;
  for (const auto& chunk : chunks) bytes += array_bytes(chunk);
  EXPECT_EQ(bytes, 6 * fields.contact_bytes());
  double toi = 0;
  std::memcpy(&toi, chunks[2].toi().data(), 8);
  EXPECT_EQ(toi, 0.4);
  std::array<uint32_t, 4> stencil{};
  std::memcpy(stencil.data(), chunks[2].stencils().data(), 16);
  EXPECT_EQ(stencil, (std::array<uint32_t, 4>{7, 0, 1, 2}));
  std::memcpy(stencil.data(), chunks[3].stencils().data(), 16);
  EXPECT_EQ(stencil, (std::array<uint32_t, 4>{0, 1, 3, 4}));
}

TEST(Chunks, OfSetsTellTheWorldOfEachContact) {
  FrameResult result;
  result.edge_edge.elements = {{0, 1}, {0, 2}, {0, 1}, {0, 3}, {1, 2}};
  result.worlds.begin.edge_edge = {0, 2, 2, 3, 3, 5, 5};  // of six worlds
  const OutputFields fields{.columns = {ContactField::kElements}, .worlds = true};
  std::vector<std::vector<uint32_t>> worlds;
  for (const Chunk& chunk : cut_into_chunks(result, fields, 2 * fields.contact_bytes(), &result.worlds.begin)) {
    pb::ContactChunk message;
    fill_chunk(chunk, {}, &message);
    EXPECT_EQ(message.elements().size() + message.worlds().size(), chunk.array_bytes());
    std::vector<uint32_t>& of_chunk = worlds.emplace_back(chunk.count());
    ASSERT_EQ(message.worlds().size(), of_chunk.size() * sizeof(uint32_t));
    std::memcpy(of_chunk.data(), message.worlds().data(), message.worlds().size());
  }
  EXPECT_EQ(worlds, (std::vector<std::vector<uint32_t>>{{0, 0}, {2, 4}, {4}}));
}

TEST(Chunks, ArraysOnTheDeviceAreThoseThatHaveBytes) {
  PlacedContacts placed;
  placed.count = 2;
  placed.elements = {0, 16}, placed.distance = {64, 16}, placed.stencils = {128, 32}, placed.features = {192, 2},
  placed.signed_distance = {256, 16};
  std::vector<std::array<uint64_t, 3>> arrays;
  for (const auto& [field, range] : arrays_of(placed))
    arrays.push_back({static_cast<uint64_t>(field), range.offset, range.bytes});
  const std::vector<std::array<uint64_t, 3>> expected{{pb::ContactChunk::kElementsFieldNumber, 0, 16},
                                                      {pb::ContactChunk::kDistanceFieldNumber, 64, 16},
                                                      {pb::ContactChunk::kFeaturesFieldNumber, 192, 2},
                                                      {pb::ContactChunk::kSignedDistancesFieldNumber, 256, 16},
                                                      {pb::ContactChunk::kStencilsFieldNumber, 128, 32}};
  EXPECT_EQ(arrays, expected);
}

TEST(Chunks, OfShortenedWaysAreBoundedAndInOrder) {
  const ShortenedWays ways{{2, 3, 5, 7, 11}, {0, 0.25, 0.5, 0.75, 0.125}};
  EXPECT_EQ(server::array_bytes(ways), 60u);
  EXPECT_TRUE(cut_into_chunks(ShortenedWays(), 100).empty());
  for (const size_t max_bytes : {1, 12, 35, 36, 59, 60, 1000}) {
    const size_t most = std::max<size_t>(1, max_bytes / 12);
    std::string ids, fractions;
    for (const WaysChunk& chunk : cut_into_chunks(ways, max_bytes)) {
      pb::ShortenedWays message;
      fill_ways(chunk, &message);
      EXPECT_LE(message.ids().size(), most * sizeof(uint32_t)) << max_bytes;
      EXPECT_EQ(message.fractions().size(), 2 * message.ids().size());
      EXPECT_GT(message.ids().size(), 0u);
      ids += message.ids(), fractions += message.fractions();
    }
    EXPECT_EQ(ids, std::string(reinterpret_cast<const char*>(ways.ids.data()), 20)) << max_bytes;
    EXPECT_EQ(fractions, std::string(reinterpret_cast<const char*>(ways.fractions.data()), 40)) << max_bytes;
  }
}

TEST(Chunks, WhatWasNotComputedIsLeftOut) {
  FrameResult result;
  Topology topology;
  topology.triangles = {{0, 1, 2}, {3, 4, 5}};
  result.vertex_triangle.elements = {{3, 0}};
  result.triangle_triangle.elements = {{0, 1}};
  result.triangle_triangle.flags = {kFlagCertified};
  const OutputFields fields{test::kEveryField, true};
  const auto chunks = messages(result, topology, fields, 1000);
  ASSERT_EQ(chunks.size(), 2u);
  EXPECT_EQ(array_bytes(chunks[0]), 8u + 16);
  EXPECT_EQ(chunks[1].kind(), pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  EXPECT_EQ(array_bytes(chunks[1]), 8u + 1);
  EXPECT_EQ(chunks[1].flags(), "\1");
}

}  // namespace
}  // namespace collided::server
