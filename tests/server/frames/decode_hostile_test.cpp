// Requests of the frame stream that are truncated, damaged, or have false lengths.
#include <gtest/gtest.h>

#include <random>

#include "server/convert/wire_bounds.hpp"
#include "server/errors.hpp"
#include "tests/server/frames/wire_request.hpp"

namespace collided::server {
namespace {

TEST(FrameDecodeHostile, EveryTruncationIsReadAsByTheGeneratedParser) {
  for (const FrameShape shape : {FrameShape{.start = true}, FrameShape{.value_bytes = 8, .sparse = true}}) {
    const std::string wire = frame_request(shape).SerializeAsString();
    size_t refused = 0;
    for (size_t bytes = 0; bytes < wire.size(); ++bytes)
      refused += expect_same(wire.substr(0, bytes)) == Verdict::kRefused;
    EXPECT_EQ(refused, wire.size() - 1);  // all but the empty one
  }
}

TEST(FrameDecodeHostile, EveryTruncationWithinTheLengthsIsReadAsByTheGeneratedParser) {
  const std::string update = frame_request({.start = true}).frame().updates(0).SerializeAsString();
  for (size_t bytes = 0; bytes <= update.size(); ++bytes) expect_same(field(2, field(3, update.substr(0, bytes))));
}

TEST(FrameDecodeHostile, SmallPiecesMakeNoDifference) {
  for (const FrameShape shape : {FrameShape{.start = true}, FrameShape{.value_bytes = 8, .sparse = true}}) {
    const std::string wire = frame_request(shape).SerializeAsString();
    for (int block = 1; block <= 7; ++block) {
      EXPECT_EQ(expect_same(wire, block), Verdict::kSame);
      for (size_t bytes = 1; bytes < wire.size(); bytes += 3)
        EXPECT_EQ(expect_same(wire.substr(0, bytes), block), Verdict::kRefused);
    }
  }
}

TEST(FrameDecodeHostile, DamagedBytesAreReadAsByTheGeneratedParser) {
  constexpr int kTries = 20'000;
  std::mt19937 random(1);
  const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
  const std::string wires[] = {frame_request({.start = true}).SerializeAsString(),
                               frame_request({.value_bytes = 8, .sparse = true}).SerializeAsString(),
                               field(1, field(1, "scene") + varint(2 << 3) + varint(4) + field(4, "token"))};
  size_t same = 0, refused = 0;
  for (int i = 0; i < kTries; ++i) {
    std::string wire = wires[below(std::size(wires))];
    // Most bytes are positions, where nothing can go wrong, so heads are hit more often.
    const size_t place = i % 2 == 0 ? below(wire.size()) : below(std::min<size_t>(wire.size(), 32));
    wire[place] = static_cast<char>(below(256));
    const Verdict verdict = expect_same(wire, static_cast<int>(below(8)));
    same += verdict == Verdict::kSame;
    refused += verdict == Verdict::kRefused;
    if (testing::Test::HasFailure()) FAIL() << "try " << i << ", byte " << place;
  }
  EXPECT_GT(same, 1000u);
  EXPECT_GT(refused, 1000u);
}

TEST(FrameDecodeHostile, LengthsThatLieAreRefused) {
  const std::string positions(100, 'p');
  const uint64_t k31 = uint64_t{1} << 31, k32 = uint64_t{1} << 32, k63 = uint64_t{1} << 63;
  for (const uint64_t length : {uint64_t{101}, k31 - 1, k31, k31 + 100, k32 - 1, k32, k32 + 100, k63, k63 + 100,
                                ~uint64_t{0} - 1, ~uint64_t{0}}) {
    const std::string update = field(5, positions, length);
    const std::string wires[] = {field(2, field(3, update)),
                                 field(2, field(3, field(4, positions, length))),  // positions
                                 field(2, field(3, field(5, positions), length)),  // an update
                                 field(2, field(3, field(5, positions)), length),  // a frame
                                 field(1, positions, length),
                                 field(1, field(1, positions, length)),  // an opening and its scene id
                                 field(9, positions, length),
                                 field(2, field(9, positions, length)),  // unknown fields
                                 field(2, field(3, field(9, positions, length))),
                                 field(2, field(3, field(2, positions, length)))};
    for (const std::string& wire : wires) EXPECT_EQ(expect_same(wire), Verdict::kRefused) << length;
  }
}

TEST(FrameDecodeHostile, TagsThatAreTooLongAreRefused) {
  const std::string number = "\x88\x80\x80\x80\x80\x80\x80\x80\x80", end(1, '\0');  // a tag of ten bytes
  for (const std::string& unknown : {number + end + '\1', "\x88\x80\x80\x80\x80" + end + '\1'})
    for (const std::string& wire : {unknown, field(2, unknown), field(2, field(3, unknown))})
      EXPECT_EQ(expect_same(wire), Verdict::kRefused);
  const std::string five = "\x88\x80\x80\x80";
  EXPECT_EQ(expect_same(field(2, five + end + '\1')), Verdict::kSame);
}

TEST(FrameDecodeHostile, LengthsThatAreTooLongAreRefused) {
  const auto empty = [](int number, int size_bytes) {
    return std::string(1, static_cast<char>(number << 3 | 2)) + std::string(static_cast<size_t>(size_bytes - 1), '\x80') +
           std::string(1, '\0');
  };
  for (const int size_bytes : {5, 6, 10})
    for (const std::string& wire :
         {empty(1, size_bytes), empty(2, size_bytes), empty(9, size_bytes), field(2, empty(3, size_bytes)),
          field(2, field(3, empty(4, size_bytes))), field(2, field(3, empty(5, size_bytes)))})
      EXPECT_EQ(expect_same(wire), size_bytes == 5 ? Verdict::kSame : Verdict::kRefused);
}

// Nobody sends groups, but whatever skips them must find their ends where the generated parser does.
TEST(FrameDecodeHostile, GroupsAreSkippedAsByTheGeneratedParser) {
  const auto group = [](const std::string& inside) { return "\x73" + inside + "\x74"; };  // of field 14
  const auto verdicts = [](const std::string& unknown, Verdict expected) {
    for (const std::string& wire : {unknown, field(2, unknown), field(2, field(3, unknown))})
      EXPECT_EQ(expect_same(wire), expected);
  };
  for (const std::string& good : {group(""), group(field(9, "bytes")), group(group("\x08\x01"))})
    verdicts(good, Verdict::kSame);
  const std::string too_long = "\xd0\xd0\xd0\xd0\xd0\xd0\x30\x01";
  const std::string end(1, '\0');
  for (const std::string& bad : {group(too_long), group(group(too_long)), group(field(9, "bytes", uint64_t{1} << 32)),
                                 group(end), "\x73" + std::string("\x08\x01"), std::string("\x73\x7c")})
    verdicts(bad, Verdict::kRefused);
  std::string deep;
  for (int i = 0; i < 101; ++i) deep = group(deep);
  verdicts(deep, Verdict::kRefused);
}

// A message must contain as many bytes as it makes the decoder allocate.
TEST(FrameDecodeHostile, ALengthThatLiesAsksForNoRoom) {
  Room room(4096);
  const std::string wire = field(2, field(3, field(5, std::string(10, 'p'), 1 << 30)));
  EXPECT_THROW(decode(wire, room), InvalidInput);
  EXPECT_EQ(room.asked(), 0);
}

TEST(FrameDecodeHostile, MoreUpdatesThanMeshesAreNotRead) {
  std::string updates;
  for (int i = 0; i < 1000; ++i) updates += field(3, "");
  Room room(4096);
  const auto decoded = decode(field(2, varint(1 << 3) + varint(7) + updates), room, 0, 3);
  EXPECT_EQ(decoded.message.frame().frame_id(), 7u);
  EXPECT_EQ(decoded.message.frame().updates_size(), static_cast<int>(max_frame_meshes(3)));
  EXPECT_THROW(std::rethrow_exception(decoded.refusal), InvalidInput);
  EXPECT_FALSE(decode(field(2, varint(1 << 3) + varint(7) + updates.substr(0, 6)), room, 0, 3).refusal);
  // Those that only an edit could explain.
  EXPECT_TRUE(decode(field(2, varint(1 << 3) + varint(7) + updates.substr(0, 8)), room, 0, 3).refusal);
  EXPECT_FALSE(decode(field(2, varint(1 << 3) + varint(7) + updates.substr(0, 8) + field(11, "")), room, 0, 3).refusal);
  // Without an id before them there is no frame to answer.
  EXPECT_THROW(decode(field(2, updates + varint(1 << 3) + varint(7)), room, 0, 3), InvalidInput);
}

TEST(FrameDecodeHostile, ManyFieldsAreNotRead) {
  std::string unknown;
  for (int i = 0; i < 5000; ++i) unknown += varint(500 << 3) + '\1';
  Room room(4096);
  for (const std::string& wire : {unknown, field(1, unknown), field(2, unknown), field(2, field(3, unknown)),
                                  field(2, field(3, field(2, unknown)))})
    EXPECT_THROW(decode(wire, room, 0, 3), LimitExceeded);
}

TEST(FrameDecodeHostile, BeforeTheOpeningNoFrameIsRead) {
  Room room(4096);
  const std::string wire = frame_request({}).SerializeAsString();
  EXPECT_THROW(decode(wire, room, 0, std::nullopt), FailedPrecondition);
  EXPECT_EQ(room.asked(), 0);
  EXPECT_TRUE(decode(field(1, field(1, "scene")), room, 0, std::nullopt).message.has_open());
}

TEST(FrameDecodeHostile, RefusalsNameTheMessage) {
  const auto field_of = [](const std::string& wire) -> std::string {
    Room room(4096);
    try {
      decode(wire, room);
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.what(), e.field() + " is cut off or malformed: its bytes are not such a message");
      return e.field();
    }
    return "accepted";
  };
  EXPECT_EQ(field_of("x"), "request");
  EXPECT_EQ(field_of(field(1, "x")), "request.open");
  EXPECT_EQ(field_of(field(2, "x")), "frame");
  EXPECT_EQ(field_of(field(2, "", 5)), "frame");
  EXPECT_EQ(field_of(field(2, field(3, "x"))), "frame.updates");
  EXPECT_EQ(field_of(field(2, field(3, field(5, "", 99)))), "frame.updates");
  EXPECT_EQ(field_of(std::string(1, '\0')), "request");
}

}  // namespace
}  // namespace collided::server
