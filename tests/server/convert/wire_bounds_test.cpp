// Bounds of messages, counted on their bytes.
#include "server/convert/wire_bounds.hpp"

#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <gtest/gtest.h>

#include "server/errors.hpp"
#include "tests/server/frames/wire_request.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMany = 1'000'000;

const auto& kFrame = *pb::Frame::descriptor();

uint64_t count(const std::string& bytes, uint64_t most = kMany) {
  FieldCount fields("frame", most);
  fields.add_message(bytes, kFrame, "frame");
  return fields.fields();
}

/// The field of the refusal.
std::string refused(const std::string& bytes) {
  try {
    count(bytes);
  } catch (const InvalidInput& e) {
    EXPECT_EQ(std::string(e.what()).rfind(e.field(), 0), 0u) << e.what();
    return e.field();
  }
  return "";
}

std::string tag(uint32_t number, uint32_t type) { return varint(number << 3 | type); }

TEST(WireBounds, FieldsOfAllLevelsCount) {
  EXPECT_EQ(count(""), 0u);
  const std::string update = field(5, std::string(100, 'p')) + tag(1, 0) + varint(7);
  EXPECT_EQ(count(tag(1, 0) + varint(9) + field(3, update) + field(3, update)), 7u);
  EXPECT_EQ(count(field(3, field(2, field(1, "abcd")))), 3u);  // indices of an update
}

TEST(WireBounds, UnknownFieldsCount) {
  std::string bytes;
  for (int i = 0; i < 50; ++i) bytes += tag(1000, 0) + varint(1);
  EXPECT_EQ(count(bytes), 50u);
  EXPECT_EQ(count(field(3, bytes)), 51u);
  EXPECT_EQ(count(field(3, field(2, bytes))), 52u);
  EXPECT_EQ(count(tag(77, 5) + "1234" + tag(78, 1) + "12345678" + field(79, bytes)), 3u);
}

TEST(WireBounds, PackedArraysCountByWhatTheyTakeInMemory) {
  FieldCount fields("spec", kMany);
  fields.add_message(field(8, std::string(1000, '\1')), *pb::SceneSpec::descriptor(), "spec");
  EXPECT_EQ(fields.fields(), 1 + 1000 / kPackedBytesOfField);
}

TEST(WireBounds, PastTheMostIsRefusedWhereItIsPassed) {
  std::string bytes;
  for (int i = 0; i < 100; ++i) bytes += field(3, "");
  EXPECT_EQ(count(bytes, 100), 100u);
  for (const std::string& more : {bytes + field(3, ""), bytes + tag(1000, 0) + varint(1), bytes + bytes + "\xff"}) try {
      count(more, 100);
      ADD_FAILURE();
    } catch (const LimitExceeded& e) {
      EXPECT_EQ(e.field(), "frame");
      EXPECT_NE(std::string(e.what()).find("more than 100 fields"), std::string::npos) << e.what();
    }
}

TEST(WireBounds, GroupsCount) {
  const std::string group = tag(50, 3) + tag(51, 0) + varint(1) + field(52, "abc") + tag(50, 4);
  EXPECT_EQ(count(group), 3u);
  EXPECT_EQ(count(field(3, group + group)), 7u);
  EXPECT_EQ(refused(tag(50, 3)), "frame");                                 // no end
  EXPECT_EQ(refused(tag(50, 3) + tag(51, 4)), "frame");                    // another one's end
  EXPECT_EQ(refused(tag(50, 4)), "frame");                                 // an end alone
  EXPECT_EQ(refused(field(3, tag(50, 3)) + tag(50, 4)), "frame.updates");  // an end outside
}

TEST(WireBounds, DeepNestingIsRefused) {
  std::string open, close;
  for (int i = 0; i < 100; ++i) {
    open += tag(50, 3);
    close += tag(50, 4);
  }
  EXPECT_EQ(refused(open + close), "frame");
  EXPECT_EQ(refused(open), "frame");
}

TEST(WireBounds, EveryTruncationIsRefused) {
  const pb::Frame frame = frame_request({.start = true}).frame();
  const std::string bytes = frame.SerializeAsString();
  ASSERT_EQ(refused(bytes), "");
  for (size_t size = 1; size < bytes.size(); ++size) {
    pb::Frame parsed;
    EXPECT_EQ(refused(bytes.substr(0, size)).empty(), parsed.ParseFromString(bytes.substr(0, size))) << size;
  }
}

TEST(WireBounds, WhatIsNoFieldIsRefused) {
  EXPECT_EQ(refused(std::string(11, '\xff')), "frame");                     // a tag that is too long
  EXPECT_EQ(refused(tag(1, 0) + std::string(10, '\xff') + '\1'), "frame");  // a value that is too long
  EXPECT_EQ(refused(tag(0, 0) + varint(1)), "frame");                       // field 0
  EXPECT_EQ(refused(tag(1, 6)), "frame");                                   // not a wire type
  EXPECT_EQ(refused(field(3, "", 5)), "frame");                             // false lengths
  EXPECT_EQ(refused(field(3, field(5, "", ~uint64_t{0}))), "frame.updates");
  EXPECT_EQ(refused(field(3, field(2, tag(1, 2)))), "frame.updates.sparse");
  EXPECT_EQ(refused(field(3, std::string(1, '\0')) + tag(1, 0) + varint(9)), "frame.updates");  // a tag of nothing
}

// The bound is meant to be one.
TEST(WireBounds, HoldForWhatIsParsed) {
  constexpr uint64_t kMeshes = 20;
  pb::Frame whole, empty;
  for (uint32_t mesh = 0; mesh < kMeshes; ++mesh) {
    *whole.add_updates() = frame_request({.start = true, .sparse = true}).frame().updates(1);
    whole.mutable_updates()->rbegin()->mutable_rigid()->set_matrix(std::string(96, 'm'));
  }
  EXPECT_LE(count(whole.SerializeAsString()), max_fields(kMeshes));
  for (uint64_t i = 0; i < max_fields(kMeshes); ++i) empty.add_updates();
  for (const pb::Frame& frame : {whole, empty}) {
    const std::string bytes = frame.SerializeAsString();
    EXPECT_LE(count(bytes), max_fields(kMeshes));
    EXPECT_LE(frame.SpaceUsedLong(), max_parsed_bytes(bytes.size(), kMeshes));
  }
}

// A frame of a set may name all its worlds; what an array takes in memory is bounded all the same.
TEST(WireBounds, LeaveRoomForEveryWorldOfASet) {
  pb::Frame frame;
  for (uint32_t world = 0; world < kMaxWorlds; ++world) frame.add_worlds(world);
  const std::string bytes = frame.SerializeAsString();
  EXPECT_LE(count(bytes), max_fields(1, kMaxWorlds));
  EXPECT_GT(count(bytes), max_fields(1));
  EXPECT_LE(frame.SpaceUsedLong(), bytes.size() + count(bytes) * kFieldBytes);
}

// Positions are skipped, however the bytes are cut into pieces.
TEST(WireBounds, PiecesMakeNoDifference) {
  const std::string bytes = frame_request({.start = true, .sparse = true}).frame().SerializeAsString();
  for (int block = 1; block < 9; ++block) {
    google::protobuf::io::ArrayInputStream stream(bytes.data(), static_cast<int>(bytes.size()), block);
    google::protobuf::io::CodedInputStream in(&stream);
    in.PushLimit(static_cast<int>(bytes.size()));
    FieldCount fields("frame", kMany);
    fields.add_message(in, kFrame, "frame");
    EXPECT_EQ(fields.fields(), count(bytes));
  }
}

}  // namespace
}  // namespace collided::server
