// Client library without a daemon: arrays of contacts, packed positions, errors.

#include "client/cpp/client.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace collided::client {
namespace {

template <class T>
std::string bytes(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T)};
}

v1::ContactChunk chunk_of_two() {
  v1::ContactChunk chunk;
  chunk.set_kind(v1::CONTACT_KIND_EDGE_EDGE);
  chunk.set_count(2);
  chunk.set_elements(bytes<uint32_t>({1, 2, 1, 3}));
  chunk.set_toi(bytes<double>({0.25, 0.1}));
  chunk.set_flags(bytes<uint8_t>({1, 8}));
  return chunk;
}

TEST(Contacts, ChunksAreJoined) {
  Contacts contacts;
  append(contacts, chunk_of_two());
  append(contacts, chunk_of_two());
  EXPECT_EQ(contacts.count, 4u);
  EXPECT_EQ(contacts.elements[3], (std::array<uint32_t, 2>{1, 3}));
  EXPECT_EQ(contacts.toi, (std::vector<double>{0.25, 0.1, 0.25, 0.1}));
  EXPECT_EQ(contacts.flags[1], 8);
  EXPECT_TRUE(contacts.distance.empty());
}

TEST(Contacts, ArraysOfTheWrongLengthAreRefused) {
  Contacts contacts;
  v1::ContactChunk chunk = chunk_of_two();
  chunk.set_count(3);
  EXPECT_THROW(append(contacts, chunk), Error);
  contacts = {};
  append(contacts, chunk_of_two());
  chunk = chunk_of_two();
  chunk.set_distance(bytes<double>({1, 2}));  // the chunk before had none
  EXPECT_THROW(append(contacts, chunk), Error);
}

TEST(Positions, ArePackedInBothFormats) {
  const std::vector<std::array<double, 3>> positions{{0.1, -2, 3}, {4, 5, 6}};
  EXPECT_EQ(pack_positions(positions, v1::POSITION_FORMAT_F32), bytes<float>({0.1f, -2, 3, 4, 5, 6}));
  EXPECT_EQ(pack_positions(positions, v1::POSITION_FORMAT_F64), bytes<double>({0.1, -2, 3, 4, 5, 6}));
  EXPECT_THROW(pack_positions(positions, v1::POSITION_FORMAT_Q16), Error);
  const v1::MeshUpdate update = mesh_update(4, v1::POSITION_FORMAT_F64, positions);
  EXPECT_EQ(update.mesh(), 4u);
  EXPECT_TRUE(update.start_positions().empty());
}

TEST(Errors, CarryCodeMessageAndField) {
  FrameOutput output;
  EXPECT_NO_THROW(output.check());
  output.error.emplace();
  output.error->set_code(3);
  output.error->set_message("NaN");
  output.error->set_field("frame.updates[0]");
  try {
    output.check();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), 3);
    EXPECT_EQ(e.field(), "frame.updates[0]");
    EXPECT_STREQ(e.what(), "INVALID_ARGUMENT: NaN");
  }
}

TEST(Connect, NamesTheAddressWhereNobodyAnswers) {
  try {
    Client::connect("unix:/nonexistent/socket", std::chrono::milliseconds(200));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), 14);
    EXPECT_NE(e.message().find("unix:/nonexistent/socket"), std::string::npos);
  }
}

}  // namespace
}  // namespace collided::client
