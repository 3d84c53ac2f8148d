// Answers of the frame stream on the wire: the generated parser reads what the engine found.
#include "server/transport/grpc/encode.hpp"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "server/convert/chunks.hpp"
#include "server/convert/mesh_pairs.hpp"
#include "server/frames/answer.hpp"
#include "tests/server/scenes/tiny_scene.hpp"
#include "tests/support/every_field.hpp"

namespace collided::server {
namespace {

constexpr OutputFields kAllFields{test::kEveryField, true};

std::string text(const grpc::ByteBuffer& bytes) {
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(bytes.Dump(&slices).ok());
  std::string out;
  for (const auto& slice : slices) out.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return out;
}

pb::StreamFramesResponse parse(const EncodedMessage& message) {
  const std::string wire = text(message.bytes);
  EXPECT_EQ(wire.size(), message.size);
  pb::StreamFramesResponse response;
  EXPECT_TRUE(response.ParseFromString(wire));
  return response;
}

// In separate messages, then with the end.
std::vector<pb::ContactChunk> chunks_of(const std::vector<EncodedMessage>& messages) {
  std::vector<pb::ContactChunk> chunks;
  for (const auto& message : messages) {
    const auto response = parse(message);
    if (response.has_contacts()) chunks.push_back(response.contacts());
    chunks.insert(chunks.end(), response.done().contacts().begin(), response.done().contacts().end());
  }
  return chunks;
}

size_t array_bytes(const pb::ContactChunk& chunk) {
  return chunk.elements().size() + chunk.stencils().size() + chunk.toi().size() + chunk.distance().size() +
         chunk.weights().size() + chunk.normals().size() + chunk.flags().size() + chunk.features().size() +
         chunk.signed_distances().size();
}

class FrameEncode : public testing::Test {
 protected:
  SceneUse scene_with(const OutputFields& fields) {
    ScenePlan plan = tip_plan();
    plan.fields = fields;
    return bench_.add(client(), {std::move(plan), "", 0, 30});
  }
  // Contacts that are all different; ids are those of the tip scene.
  static ContactSet contacts(uint32_t count, uint32_t firsts, uint32_t seconds) {
    std::vector<std::array<uint32_t, 2>> elements;
    std::vector<double> toi, distance, with_sign;
    std::vector<std::array<double, 2>> weights;
    std::vector<Normal> normals;
    std::vector<uint8_t> flags, features;
    for (uint32_t i = 0; i < count; ++i) {
      elements.push_back({i % firsts, i / firsts % seconds});
      toi.push_back(1.0 / (i + 1));
      distance.push_back(0.5 * i);
      with_sign.push_back(-0.25 * i);
      weights.push_back({0.25 * i, 0.125 * i});
      normals.push_back({0.5f * static_cast<float>(i), 1, 2});
      flags.push_back(static_cast<uint8_t>(i % 16));
      features.push_back(static_cast<uint8_t>(i % 128));
    }
    return {{elements, toi, distance, weights, normals, flags, features, with_sign}};
  }
  static std::shared_ptr<AnsweredFrame> frame(uint32_t vertex_triangle, uint32_t edge_edge,
                                              uint32_t triangle_triangle) {
    const auto frame = std::make_shared<AnsweredFrame>();
    frame->frame_id = uint64_t{1} << 40;
    frame->arrival = std::chrono::steady_clock::now();
    frame->result.vertex_triangle = contacts(vertex_triangle, 6, 2);
    frame->result.edge_edge = contacts(edge_edge, 6, 6);
    auto& pairs = frame->result.triangle_triangle = contacts(triangle_triangle, 1, 2);
    pairs.toi = {}, pairs.distance = {}, pairs.weights = {}, pairs.normals = {}, pairs.features = {},
    pairs.signed_distance = {};
    frame->result.any_contact = true;
    return frame;
  }

  SceneBench bench_;
};

TEST_F(FrameEncode, TheGeneratedParserReadsWhatFillChunkWrites) {
  const auto scene = scene_with(kAllFields);
  for (const size_t most : {size_t{1}, size_t{100}, size_t{5000}, size_t{1} << 16, size_t{2} << 20}) {
    const auto answer = frame(700, 500, 300);
    const auto chunks = cut_into_chunks(answer->result, kAllFields, most);
    const auto messages = encode_answer(*scene, answer, most);
    const auto sent = chunks_of(messages);
    ASSERT_EQ(sent.size(), chunks.size());
    for (size_t i = 0; i < chunks.size(); ++i) {
      pb::ContactChunk expected;
      fill_chunk(chunks[i], scene->engine().topology(), &expected);
      ASSERT_EQ(sent[i].SerializeAsString(), expected.SerializeAsString()) << most;
    }
    pb::StreamFramesResponse end, sent_end = parse(messages.back());
    end.set_frame_id(answer->frame_id);
    *end.mutable_done() = done_message(*answer);
    sent_end.mutable_done()->clear_contacts();
    EXPECT_EQ(sent_end.SerializeAsString(), end.SerializeAsString());
  }
}

TEST_F(FrameEncode, NoContactIsLostAndChunksStayBelowTheBound) {
  constexpr size_t kMax = 10'000;
  const auto scene = scene_with(kAllFields);
  const auto answer = frame(5000, 3001, 17);
  std::string elements, toi;
  size_t counted = 0, bytes = 0;
  const auto messages = encode_answer(*scene, answer, kMax);
  for (const auto& message : messages) {
    const auto response = parse(message);
    size_t message_bytes = array_bytes(response.contacts());
    for (const auto& chunk : response.done().contacts()) message_bytes += array_bytes(chunk);
    EXPECT_LE(message_bytes, kMax);
  }
  for (const auto& chunk : chunks_of(messages)) {
    EXPECT_GE(chunk.count(), 1u);
    counted += chunk.count();
    bytes += array_bytes(chunk);
    elements += chunk.elements();
    toi += chunk.toi();
  }
  EXPECT_EQ(counted, 5000u + 3001 + 17);
  EXPECT_EQ(bytes, answer->cost.bytes_out);
  const auto all = [](const auto&... sets) {
    return (std::string(reinterpret_cast<const char*>(sets.data()), sets.size() * sizeof(sets[0])) + ...);
  };
  const FrameResult& result = answer->result;
  EXPECT_EQ(elements,
            all(result.vertex_triangle.elements, result.edge_edge.elements, result.triangle_triangle.elements));
  EXPECT_EQ(toi, all(result.vertex_triangle.toi, result.edge_edge.toi));
}

// Few vertices and many come with few contacts and many.
TEST_F(FrameEncode, NoShortenedWayIsLostAndMessagesStayBelowTheBound) {
  constexpr size_t kMax = 10'000;
  const auto scene = scene_with(kAllFields);
  for (const uint32_t count : {0u, 1u, 5u, 833u, 834u, 1666u, 5000u})
    for (const uint32_t hits : {0u, 1u, 500u}) {
      const auto answer = frame(hits, 0, 0);
      ShortenedWays& ways = answer->result.shortened;
      for (uint32_t i = 0; i < count; ++i) ways.ids.push_back(3 * i), ways.fractions.push_back(1 / (i + 2.0));
      std::string ids, fractions;
      const auto add = [&](const pb::ShortenedWays& some) { ids += some.ids(), fractions += some.fractions(); };
      const auto messages = encode_answer(*scene, answer, kMax);
      for (const auto& message : messages) {
        const auto response = parse(message);
        size_t bytes = array_bytes(response.contacts());
        for (const auto& chunk : response.done().contacts()) bytes += array_bytes(chunk);
        for (const auto* some : {&response.shortened(), &response.done().shortened()})
          bytes += some->ids().size() + some->fractions().size(), add(*some);
        EXPECT_LE(bytes, kMax);
      }
      EXPECT_EQ(messages.size() == 1, answer->cost.bytes_out <= kMax) << count << " " << hits;
      EXPECT_EQ(ids, std::string(reinterpret_cast<const char*>(ways.ids.data()), 4 * count));
      EXPECT_EQ(fractions, std::string(reinterpret_cast<const char*>(ways.fractions.data()), 8 * count));
      EXPECT_EQ(answer->cost.bytes_out, 12 * count + hits * kAllFields.contact_bytes());
    }
}

TEST_F(FrameEncode, NoPairOfMeshesIsLostAndMessagesStayBelowTheBound) {
  constexpr size_t kMax = 10'000;
  const auto scene = scene_with(kAllFields);
  for (const uint32_t count : {0u, 1u, 5u, 344u, 345u, 688u, 5000u})
    for (const uint32_t hits : {0u, 1u, 500u}) {
      const auto answer = frame(hits, 0, 0);
      for (uint32_t i = 0; i < count; ++i)
        answer->result.pair_states.push_back({.first = i, .second = i + 1, .deepest = 3 * i, .depth = 1 / (i + 2.0)});
      pb::MeshPairs expected, came;
      fill_pairs(answer->result.pair_states, &expected);
      const auto add = [&](const pb::MeshPairs& some) {
        *came.mutable_meshes() += some.meshes(), *came.mutable_states() += some.states();
        *came.mutable_inside() += some.inside(), *came.mutable_deepest() += some.deepest();
        *came.mutable_depths() += some.depths();
        return some.meshes().size() / 8 * kPairStateBytes;
      };
      const auto messages = encode_answer(*scene, answer, kMax);
      for (const auto& message : messages) {
        const auto response = parse(message);
        size_t bytes = array_bytes(response.contacts()) + add(response.pairs()) + add(response.done().pairs());
        for (const auto& chunk : response.done().contacts()) bytes += array_bytes(chunk);
        EXPECT_LE(bytes, kMax);
      }
      EXPECT_EQ(messages.size() == 1, answer->cost.bytes_out <= kMax) << count << " " << hits;
      EXPECT_EQ(came.SerializeAsString(), expected.SerializeAsString()) << count << " " << hits;
      EXPECT_EQ(answer->cost.bytes_out, kPairStateBytes * count + hits * kAllFields.contact_bytes());
    }
}

// Whatever the scene asks for, they have all arrays.
TEST_F(FrameEncode, NoLimitIsLostAndMessagesStayBelowTheBound) {
  constexpr size_t kMax = 10'000;
  const auto scene = scene_with({{ContactField::kToi}, false});
  for (const uint32_t count : {0u, 1u, 100u, 5000u})
    for (const uint32_t hits : {0u, 1u, 3000u}) {
      const auto answer = frame(hits, 0, 0);
      answer->result.limits.vertex_triangle = contacts(count, 6, 2);
      answer->result.limits.edge_edge = contacts(count / 2, 6, 6);
      for (uint32_t i = 0; i < count; ++i)
        answer->result.shortened.ids.push_back(i), answer->result.shortened.fractions.push_back(0.5);
      std::vector<pb::ContactChunk> limits;
      uint64_t came = 0;
      const auto messages = encode_answer(*scene, answer, kMax);
      for (const auto& message : messages) {
        const auto response = parse(message);
        size_t bytes = array_bytes(response.contacts()) + array_bytes(response.limits());
        if (response.has_limits()) limits.push_back(response.limits());
        for (const auto& chunk : response.done().limits()) bytes += array_bytes(chunk), limits.push_back(chunk);
        for (const auto& chunk : response.done().contacts()) bytes += array_bytes(chunk), came += chunk.count();
        bytes += response.done().shortened().ids().size() + response.done().shortened().fractions().size();
        came += response.contacts().count();
        EXPECT_LE(bytes, kMax);
      }
      EXPECT_EQ(came, hits);
      EXPECT_EQ(messages.size() == 1, answer->cost.bytes_out <= kMax) << count << " " << hits;
      const auto expected = cut_into_chunks(answer->result.limits, kLimitFields, kMax);
      ASSERT_EQ(limits.size(), expected.size());
      for (size_t i = 0; i < limits.size(); ++i) {
        pb::ContactChunk chunk;
        fill_chunk(expected[i], scene->engine().topology(), &chunk);
        ASSERT_EQ(limits[i].SerializeAsString(), chunk.SerializeAsString());
        EXPECT_EQ(limits[i].normals().size(), 12 * size_t{limits[i].count()});
      }
      EXPECT_EQ(answer->cost.bytes_out, 8 * hits + 12 * count + (count + count / 2) * kLimitFields.contact_bytes());
    }
}

TEST_F(FrameEncode, TheLastMessageAloneEndsTheFrame) {
  const auto scene = scene_with(kAllFields);
  for (const uint32_t count : {0u, 1u, 2000u}) {
    const auto messages = encode_answer(*scene, frame(count, count, 0), 4096);
    EXPECT_EQ(messages.size() == 1, count <= 1);  // few contacts need no separate message
    for (const auto& message : messages) {
      EXPECT_EQ(message.ends_frame, &message == &messages.back());
      EXPECT_EQ(parse(message).has_done(), message.ends_frame);
      EXPECT_EQ(parse(message).frame_id(), uint64_t{1} << 40);
    }
  }
}

TEST_F(FrameEncode, FieldsThatWereNotAskedForStayAway) {
  const auto scene = scene_with({{ContactField::kToi}, false});
  const auto messages = encode_answer(*scene, frame(400, 0, 0), 1 << 20);
  const auto chunk = chunks_of(messages).at(0);
  EXPECT_EQ(chunk.count(), 400u);
  EXPECT_EQ(array_bytes(chunk), 400 * sizeof(double));
  EXPECT_EQ(chunk.toi().size(), 400 * sizeof(double));
}

TEST_F(FrameEncode, CountsAloneStillTellHowManyThereAre) {
  const auto scene = scene_with({});
  const auto messages = encode_answer(*scene, frame(400, 0, 0), 1 << 20);
  size_t counted = 0;
  for (const auto& chunk : chunks_of(messages)) counted += chunk.count();
  EXPECT_EQ(counted, 400u);
  EXPECT_EQ(parse(messages.back()).done().contact_count(), 400u);
}

// The arrays are sent in place.
TEST_F(FrameEncode, MessagesKeepTheirFrameAsLongAsTheyNeedIt) {
  const auto scene = scene_with(kAllFields);
  auto answer = frame(1000, 0, 0);
  const std::weak_ptr<AnsweredFrame> alive = answer;
  constexpr size_t kMax = 30'000;  // so that the first message is contacts alone, and the same each time
  const std::string first_before = text(encode_answer(*scene, answer, kMax).at(0).bytes);
  auto messages = encode_answer(*scene, answer, kMax);
  answer.reset();
  EXPECT_FALSE(alive.expired());
  EXPECT_EQ(text(messages[0].bytes), first_before);
  grpc::ByteBuffer copy = messages[0].bytes;
  messages.clear();
  EXPECT_EQ(text(copy), first_before);
  EXPECT_FALSE(alive.expired());
  copy.Clear();
  EXPECT_TRUE(alive.expired());
}

TEST_F(FrameEncode, TheCostIsComplete) {
  const auto scene = scene_with(kAllFields);
  const auto answer = frame(1000, 0, 0);
  const auto messages = encode_answer(*scene, answer, 1 << 20);
  EXPECT_EQ(answer->cost.bytes_out, 1000 * kAllFields.contact_bytes());
  EXPECT_GT(answer->cost.encode_milliseconds, 0);
  EXPECT_GE(answer->cost.total_milliseconds, answer->cost.encode_milliseconds);
  const auto metrics = parse(messages.back()).done().metrics();
  EXPECT_EQ(metrics.bytes_out(), answer->cost.bytes_out);
  EXPECT_EQ(metrics.encode_milliseconds(), answer->cost.encode_milliseconds);
}

TEST_F(FrameEncode, OfSmallMessagesThoseThatEndAFrameGiveTheCreditBack) {
  const auto ends = [](const std::function<void(pb::StreamFramesResponse&)>& set) {
    pb::StreamFramesResponse response;
    response.set_frame_id(3);
    set(response);
    const auto message = encode(response);
    EXPECT_EQ(parse(message).SerializeAsString(), response.SerializeAsString());
    return message.ends_frame;
  };
  EXPECT_TRUE(ends([](auto& r) { r.mutable_error()->set_message(std::string(5000, 'm')); }));
  EXPECT_TRUE(ends([](auto& r) { r.mutable_skipped(); }));
  EXPECT_FALSE(ends([](auto& r) { r.mutable_opened()->set_window(2); }));
  EXPECT_FALSE(ends([](auto& r) { r.mutable_draining()->set_deadline_seconds(2); }));
}

}  // namespace
}  // namespace collided::server
