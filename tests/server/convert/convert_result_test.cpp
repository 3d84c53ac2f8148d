// Results from the engine to the protocol: chunks and the end of a frame.
#include <gtest/gtest.h>

#include "server/convert/chunks.hpp"
#include "tests/server/convert/scene_request.hpp"

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
         chunk.weights().size() + chunk.flags().size();
}

TEST(ConvertResult, ChunksAreBoundedAndCarryTheFieldsAskedFor) {
  FrameResult result;
  Topology topology;
  topology.triangles = {{0, 1, 2}};
  topology.edges = {{0, 1}, {3, 4}};
  result.vertex_triangle.elements = {{3, 0}, {4, 0}, {5, 0}, {6, 0}, {7, 0}};
  result.vertex_triangle.toi = {0, 0.1, 0.2, 0.3, 0.4};
  result.edge_edge.elements = {{0, 1}};
  result.edge_edge.toi = {0.5};
  const OutputFields fields{.stencils = true, .toi = true};
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

TEST(ConvertResult, WhatWasNotComputedIsLeftOut) {
  FrameResult result;
  Topology topology;
  topology.triangles = {{0, 1, 2}, {3, 4, 5}};
  result.vertex_triangle.elements = {{3, 0}};
  result.triangle_triangle.elements = {{0, 1}};
  result.triangle_triangle.flags = {kFlagCertified};
  const OutputFields fields{
      .elements = true, .stencils = true, .toi = true, .distance = true, .weights = true, .flags = true};
  const auto chunks = messages(result, topology, fields, 1000);
  ASSERT_EQ(chunks.size(), 2u);
  EXPECT_EQ(array_bytes(chunks[0]), 8u + 16);
  EXPECT_EQ(chunks[1].kind(), pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  EXPECT_EQ(array_bytes(chunks[1]), 8u + 1);
  EXPECT_EQ(chunks[1].flags(), "\1");
}

TEST(ConvertResult, DoneTellsWhatTheStepCost) {
  FrameResult result;
  result.replays = 1;
  result.allocations = 2;
  result.graph_launches = 3;
  result.step_milliseconds = 0.25;
  FrameCost cost;
  cost.queue_milliseconds = 1;
  cost.decode_milliseconds = 2;
  cost.engine_milliseconds = 3;
  cost.encode_milliseconds = 4;
  cost.total_milliseconds = 10;
  cost.device_bytes = 11;
  cost.bytes_in = 12;
  cost.bytes_out = 13;
  for (const auto& [message, engine] : kEngines) {
    result.engine = engine;
    pb::FrameDone done;
    fill_done(result, cost, &done);
    EXPECT_EQ(done.metrics().queue_milliseconds(), 1);
    EXPECT_EQ(done.metrics().decode_milliseconds(), 2);
    EXPECT_EQ(done.metrics().engine_milliseconds(), 3);
    EXPECT_EQ(done.metrics().encode_milliseconds(), 4);
    EXPECT_EQ(done.metrics().total_milliseconds(), 10);
    EXPECT_EQ(done.metrics().device_bytes(), 11u);
    EXPECT_EQ(done.metrics().bytes_in(), 12u);
    EXPECT_EQ(done.metrics().bytes_out(), 13u);
    EXPECT_EQ(done.metrics().replays(), 1u);
    EXPECT_EQ(done.metrics().allocations(), 2u);
    EXPECT_EQ(done.metrics().graph_launches(), 3u);
    EXPECT_EQ(done.metrics().step_milliseconds(), 0.25);
    EXPECT_EQ(done.metrics().broad_phase_engine(), message);
  }
}

TEST(ConvertResult, DoneTellsTotalsCountsAndWarnings) {
  FrameResult result;
  result.vertex_triangle.elements = {{3, 0}};
  result.triangle_triangle.elements = {{0, 1}, {0, 2}};
  result.counts.contacts_tt = 2;
  result.counts.survivors_vt = 3;
  result.counts.survivors_ee = 4;
  result.counts.exact_decisions = 5;
  result.earliest_toi = 0.5;
  result.any_contact = true;
  pb::FrameDone done;
  fill_done(result, {}, &done);
  EXPECT_EQ(done.contact_count(), 3u);
  EXPECT_TRUE(done.any_contact());
  EXPECT_EQ(done.earliest_toi(), 0.5);
  EXPECT_EQ(done.metrics().counts().contacts_triangle_triangle(), 2u);
  EXPECT_EQ(done.metrics().counts().survivors_vertex_triangle(), 3u);
  EXPECT_EQ(done.metrics().counts().survivors_edge_edge(), 4u);
  EXPECT_EQ(done.metrics().counts().exact_decisions(), 5u);
  EXPECT_TRUE(done.metrics().warnings().empty());
  result.input_resolution = true;
  fill_done(result, {}, &done);
  ASSERT_EQ(done.metrics().warnings_size(), 1);
  EXPECT_EQ(done.metrics().warnings(0), pb::FRAME_WARNING_INPUT_RESOLUTION);
}

}  // namespace
}  // namespace collided::server
