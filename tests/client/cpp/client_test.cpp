// Client library without a daemon: arrays of contacts, packed positions, errors.

#include "client/cpp/client.hpp"

#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <cstring>

#include "client/cpp/transport/grpc/grpc_transport.hpp"

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

/// A call that is never opened.
class ContactArrays : public testing::Test {
 protected:
  void add(const v1::ContactChunk& chunk) { append(contacts, chunk, &transport); }

  GrpcTransport transport{grpc::CreateChannel("unix:/nonexistent/socket", grpc::InsecureChannelCredentials()),
                          std::make_unique<grpc::ClientContext>(), 1 << 20};
  Contacts contacts;
};

TEST_F(ContactArrays, AreJoined) {
  add(chunk_of_two());
  add(chunk_of_two());
  EXPECT_EQ(contacts.count, 4u);
  EXPECT_EQ(contacts.elements[3], (std::array<uint32_t, 2>{1, 3}));
  EXPECT_EQ(contacts.toi, (std::vector<double>{0.25, 0.1, 0.25, 0.1}));
  EXPECT_EQ(contacts.flags[1], 8);
  EXPECT_TRUE(contacts.distance.empty());
}

TEST_F(ContactArrays, OfTheWrongLengthAreRefused) {
  v1::ContactChunk chunk = chunk_of_two();
  chunk.set_count(3);
  EXPECT_THROW(add(chunk), Error);
  contacts = {};
  add(chunk_of_two());
  chunk = chunk_of_two();
  chunk.set_distance(bytes<double>({1, 2}));  // the previous chunk had none
  EXPECT_THROW(add(chunk), Error);
}

TEST_F(ContactArrays, InSharedMemoryAreRefusedOverGrpc) {
  v1::ContactChunk chunk = chunk_of_two();
  chunk.clear_toi();
  chunk.mutable_shared()->mutable_toi()->set_size(16);
  EXPECT_THROW(add(chunk), Error);
}

TEST(ContactsOnDevice, AreNamedWithinTheRegion) {
  v1::ContactChunk chunk;
  chunk.set_count(2);
  v1::SharedArrays& shared = *chunk.mutable_shared();
  shared.mutable_elements()->set_size(16);
  shared.mutable_stencils()->set_offset(64);
  shared.mutable_stencils()->set_size(32);
  const DeviceContacts contacts = on_device(chunk, 96);
  EXPECT_EQ(contacts.count, 2u);
  EXPECT_EQ(contacts.elements.bytes, 16u);
  EXPECT_EQ(contacts.stencils.offset, 64u);
  EXPECT_EQ(contacts.toi.bytes, 0u);
  EXPECT_THROW(on_device(chunk, 95), Error);
  EXPECT_THROW(on_device(chunk, 8), Error);
  shared.mutable_stencils()->set_offset(~uint64_t{0});
  EXPECT_THROW(on_device(chunk, 96), Error);
  shared.mutable_stencils()->set_offset(0);
  chunk.set_count(3);
  EXPECT_THROW(on_device(chunk, 96), Error);
}

TEST(FrameWire, IsTheRequestAsProtobufReadsIt) {
  const std::string large(10000, 'x'), small(12, 'y'), indices = bytes<uint32_t>({4});
  v1::Frame frame;
  frame.set_frame_id(300);
  frame.set_accuracy(v1::ACCURACY_EXACT);
  frame.set_delta(0);
  frame.set_report(v1::REPORT_ANY_HIT);
  frame.add_updates()->set_positions(large);
  frame.add_updates()->set_mesh(200);
  frame.mutable_updates(1)->mutable_rigid()->set_matrix(small);
  const auto view = [](const std::string& text) { return std::as_bytes(std::span(text)); };
  const RigidMatrix here{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, there{1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7};
  const std::vector<FrameUpdate> views{
      {.mesh = 70000, .positions = view(small), .start_positions = view(large), .indices = view(indices)},
      {.positions = view(large)},
      {.mesh = 3, .transform = &there},
      {.mesh = 4, .transform = &there, .start_transform = &here}};
  const std::vector<WirePart> parts = encode_frame(frame, views);
  std::string wire;
  for (const WirePart& part : parts)
    wire += part.head + std::string(reinterpret_cast<const char*>(part.borrowed.data()), part.borrowed.size());
  EXPECT_EQ(size_of(parts), wire.size());
  v1::StreamFramesRequest read, expected;
  ASSERT_TRUE(read.ParseFromString(wire));
  v1::Frame& all = *expected.mutable_frame();
  all = frame;
  all.mutable_updates()->SwapElements(0, 1);  // what cannot be borrowed comes first
  v1::MeshUpdate& sparse = *all.add_updates();
  sparse.set_mesh(70000);
  sparse.mutable_sparse()->set_indices(indices);
  sparse.set_start_positions(large);
  sparse.set_positions(small);
  all.add_updates()->set_positions(large);
  *all.add_updates() = rigid_update(3, there);
  *all.add_updates() = rigid_update(4, there, here);
  EXPECT_EQ(read.SerializeAsString(), expected.SerializeAsString());
  for (const WirePart& part : parts) EXPECT_TRUE(part.borrowed.empty() || part.borrowed.size() == large.size());
}

TEST(FrameWire, AnEmptyFrameIsStillAFrame) {
  v1::StreamFramesRequest read;
  ASSERT_TRUE(read.ParseFromString(encode_frame({}, {}).front().head));
  EXPECT_TRUE(read.has_frame());
}

TEST(Positions, ArePackedInBothFormats) {
  const std::vector<std::array<double, 3>> positions{{0.1, -2, 3}, {4, 5, 6}};
  EXPECT_EQ(pack_positions(positions, v1::POSITION_FORMAT_F32), bytes<float>({0.1f, -2, 3, 4, 5, 6}));
  EXPECT_EQ(pack_positions(positions, v1::POSITION_FORMAT_F64), bytes<double>({0.1, -2, 3, 4, 5, 6}));
  EXPECT_THROW(pack_positions(positions, v1::POSITION_FORMAT_Q16), Error);
  EXPECT_EQ(position_bytes(v1::POSITION_FORMAT_Q16), 6u);
  const v1::MeshUpdate update = mesh_update(4, v1::POSITION_FORMAT_F64, positions);
  EXPECT_EQ(update.mesh(), 4u);
  EXPECT_TRUE(update.start_positions().empty());
}

v1::QuantizationBox box_of(double lower, double upper) {
  v1::QuantizationBox box;
  for (int k = 0; k < 3; ++k) box.add_lower(lower), box.add_upper(upper);
  return box;
}

TEST(Positions, AreEncodedToTheNearestStep) {
  const std::vector<std::array<double, 3>> positions{{-1, 0, 1}, {0.00002, -0.00002, 0.99999}};
  EXPECT_EQ(pack_quantized(positions, box_of(-1, 1)), bytes<uint16_t>({0, 32768, 65535, 32768, 32767, 65535}));
  const std::vector<std::array<double, 3>> flat{{3, 3, 3}};
  EXPECT_EQ(pack_quantized(flat, box_of(3, 3)), bytes<uint16_t>({0, 0, 0}));
  const std::vector<std::array<double, 3>> top{{0.1, 0.1, 0.1}};
  EXPECT_EQ(pack_quantized(top, box_of(-10, 0.1)), bytes<uint16_t>({65535, 65535, 65535}));
  EXPECT_THROW(pack_quantized(positions, box_of(-0.5, 1)), Error);
  EXPECT_THROW(pack_quantized(positions, box_of(1, -1)), Error);
  EXPECT_THROW(pack_quantized(positions, {}), Error);
  const std::vector<std::array<double, 3>> lost{{0, NAN, 0}};
  EXPECT_THROW(pack_quantized(lost, box_of(-1, 1)), Error);
}

TEST(Positions, OfRigidMeshesAreMovedAsTheDaemonMovesThem) {
  const RigidMatrix quarter{0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7};
  std::vector<float> positions{1, 2, 3};
  move_rigidly(std::span<float>(positions), quarter);
  EXPECT_EQ(positions, (std::vector<float>{3, 7, 10}));
  std::vector<double> two{1, 2};
  EXPECT_THROW(move_rigidly(std::span<double>(two), quarter), Error);
  const v1::MeshUpdate update = rigid_update(2, quarter, quarter);
  EXPECT_EQ(update.mesh(), 2u);
  EXPECT_EQ(update.rigid().matrix().size(), 96u);
  EXPECT_EQ(update.rigid().start_matrix(), update.rigid().matrix());
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
    Client::connect("unix:/nonexistent/socket", {.patience = std::chrono::milliseconds(200)});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), 14);
    EXPECT_NE(e.message().find("unix:/nonexistent/socket"), std::string::npos);
  }
}

}  // namespace
}  // namespace collided::client
