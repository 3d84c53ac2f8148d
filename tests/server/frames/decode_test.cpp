// Decoded requests of the frame stream: as the generated parser reads them, with the positions in place.
#include "server/frames/decode.hpp"

#include <gtest/gtest.h>

#include "tests/server/frames/wire_request.hpp"

namespace collided::server {
namespace {

TEST(FrameDecode, PositionsGoToTheRoomAndTheRestStaysInTheMessage) {
  const auto request = frame_request({.start = true});
  Room room(4096);
  const auto decoded = decode(request.SerializeAsString(), room);
  ASSERT_EQ(decoded.placed.size(), 2u);
  EXPECT_EQ(room.asked(), 1);
  for (int i = 0; i < 2; ++i) {
    const auto& placed = decoded.placed[static_cast<size_t>(i)];
    EXPECT_EQ(text(placed.end), request.frame().updates(i).positions());
    EXPECT_EQ(text(placed.start), request.frame().updates(i).start_positions());
    EXPECT_TRUE(room.holds(placed.end) && room.holds(placed.start));
    EXPECT_TRUE(decoded.message.frame().updates(i).positions().empty());
  }
  EXPECT_EQ(decoded.message.frame().frame_id(), 7u);
  EXPECT_EQ(decoded.message.frame().delta(), 0.5);
  EXPECT_EQ(whole(decoded), request.SerializeAsString());
}

TEST(FrameDecode, SparseAndDoublesAndEmptyOnes) {
  auto request = frame_request({.value_bytes = 8, .sparse = true});
  request.mutable_frame()->add_updates()->set_mesh(9);
  Room room(4096);
  const auto decoded = decode(request.SerializeAsString(), room);
  ASSERT_EQ(decoded.placed.size(), 3u);
  EXPECT_EQ(decoded.placed[0].end.size(), 8u * 3 * kVertices);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(decoded.placed[1].end.data()) % 16, 0u);
  EXPECT_EQ(decoded.message.frame().updates(1).sparse().indices(), request.frame().updates(1).sparse().indices());
  EXPECT_TRUE(decoded.placed[2].end.empty());
  EXPECT_EQ(whole(decoded), request.SerializeAsString());
}

TEST(FrameDecode, FewBytesStayInTheMessage) {
  pb::StreamFramesRequest request;
  request.mutable_frame()->add_updates()->set_positions(std::string(64, 'p'));
  Room room(4096);
  const auto decoded = decode(request.SerializeAsString(), room);
  EXPECT_EQ(room.asked(), 0);
  EXPECT_TRUE(decoded.placed.at(0).end.empty());
  EXPECT_EQ(whole(decoded), request.SerializeAsString());
}

TEST(FrameDecode, AnOpeningNeedsNoRoom) {
  pb::StreamFramesRequest request;
  request.mutable_open()->set_scene_id("scene");
  request.mutable_open()->set_window(4);
  Room room(4096);
  const auto decoded = decode(request.SerializeAsString(), room);
  EXPECT_EQ(room.asked(), 0);
  EXPECT_EQ(decoded.message.SerializeAsString(), request.SerializeAsString());
  EXPECT_TRUE(decoded.placed.empty());
  EXPECT_EQ(decode("", room).message.request_case(), pb::StreamFramesRequest::REQUEST_NOT_SET);
}

TEST(FrameDecode, WhatDoesNotFitTheRoomStaysInTheMessage) {
  const auto request = frame_request({.start = true});
  const std::string wire = request.SerializeAsString();
  for (size_t bytes = 0; bytes <= 512; ++bytes) {
    Room room(bytes);
    const auto decoded = decode(wire, room);
    ASSERT_EQ(room.asked(), 1);
    ASSERT_EQ(whole(decoded), wire) << "with room for " << bytes;
    for (const auto& placed : decoded.placed) ASSERT_TRUE(room.holds(placed.end) && room.holds(placed.start));
    ASSERT_TRUE(room.is_intact());
  }
}

// A message may be split and have fields twice: messages merge, and the last bytes count.
TEST(FrameDecode, RepeatedFieldsMergeAsInTheGeneratedParser) {
  pb::StreamFramesRequest head, update, again;
  head.mutable_frame()->set_frame_id(3);
  head.mutable_frame()->set_delta(2);
  update = frame_request({.start = true});
  again = frame_request({});
  again.mutable_frame()->set_frame_id(8);
  const std::string both = head.SerializeAsString() + update.SerializeAsString() + again.SerializeAsString();
  expect_same(both);
  Room room(4096);
  EXPECT_EQ(decode(both, room).placed.size(), 4u);
  const std::string shorter(100, 's'), longer(200, 'l'), few(8, 'f');
  for (const std::string& first : {shorter, longer, few, std::string()})
    for (const std::string& second : {shorter, longer, few, std::string()}) {
      const std::string twice = field(5, first) + field(4, second) + field(5, second) + field(4, first);
      expect_same(field(2, field(3, twice + field(2, field(1, "idx1")) + field(2, field(1, "index2")))));
    }
}

TEST(FrameDecode, UnknownFieldsAreSkippedAsInTheGeneratedParser) {
  const std::string unknown = field(100, "unknown") + varint(101 << 3) + varint(~uint64_t{0}) +  //
                              varint(102 << 3 | 1) + "12345678" + varint(103 << 3 | 5) + "1234";
  const std::string group = varint(104 << 3 | 3) + unknown + varint(104 << 3 | 4);
  const std::string update = unknown + field(5, std::string(90, 'p')) + group;
  expect_same(unknown + field(2, group + field(3, update) + unknown) + group);
  expect_same(field(2, field(3, varint(5 << 3) + varint(7))));  // positions as a number
  expect_same(field(2, varint(3 << 3 | 5) + "1234") + varint(2 << 3) + varint(1));
  const std::string bad[] = {
      varint(104 << 3 | 4),                         // a group's end without a start
      varint(104 << 3 | 3) + unknown,               // a group without an end
      varint(104 << 3 | 3) + varint(105 << 3 | 4),  // the end of another
      varint(0),
      varint(2),
      varint(101 << 3 | 6),
      varint(101 << 3 | 7)  // neither a field nor a wire type
  };
  for (const std::string& bytes : bad)
    for (const std::string& message : {bytes, field(2, bytes), field(2, field(3, bytes)), field(1, bytes)})
      EXPECT_EQ(expect_same(message), Verdict::kRefused);
}

TEST(FrameDecode, GroupsWithinGroupsEnd) {
  std::string open, close;
  for (int i = 0; i < 100'000; ++i) open += varint(104 << 3 | 3), close += varint(104 << 3 | 4);
  EXPECT_EQ(expect_same(open + close), Verdict::kRefused);
  EXPECT_EQ(expect_same(field(2, field(3, open + close))), Verdict::kRefused);
}

// The one difference: the generated parser takes the later of the two.
TEST(FrameDecode, OpenAndFrameAtOnceAreRefused) {
  const std::string open = field(1, field(1, "scene")), frame = frame_request({}).SerializeAsString();
  Room room(4096);
  for (const std::string& both : {open + frame, frame + open}) {
    try {
      decode(both, room);
      FAIL();
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.field(), "request");
      EXPECT_STREQ(e.what(), "request has `open` and `frame`, but must have one of them");
    }
  }
}

}  // namespace
}  // namespace collided::server
