#pragma once
// Requests of the frame stream as bytes, decoded by ours and by the generated parser.

#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/frames/decode.hpp"

namespace collided::server {

constexpr int kVertices = 7;

struct FrameShape {
  bool start = false;  ///< with positions at t = 0
  int value_bytes = 4;
  bool sparse = false;  ///< the second update
};

/// A frame with updates of two meshes, all bytes different from their neighbours.
inline pb::StreamFramesRequest frame_request(const FrameShape& shape) {
  pb::StreamFramesRequest request;
  pb::Frame& frame = *request.mutable_frame();
  frame.set_frame_id(7);
  frame.set_accuracy(pb::ACCURACY_GUARDED);
  frame.set_delta(0.5);
  char next = 0;
  const auto bytes = [&](int count) {
    std::string out(static_cast<size_t>(count), '\0');
    for (char& c : out) c = ++next;
    return out;
  };
  for (uint32_t mesh = 0; mesh < 2; ++mesh) {
    pb::MeshUpdate& update = *frame.add_updates();
    update.set_mesh(mesh);
    if (shape.sparse && mesh == 1) update.mutable_sparse()->set_indices(bytes(4 * kVertices));
    if (shape.start) update.set_start_positions(bytes(shape.value_bytes * 3 * kVertices));
    update.set_positions(bytes(shape.value_bytes * 3 * kVertices));
  }
  return request;
}

inline std::string varint(uint64_t value) {
  std::string out;
  for (; value >= 0x80; value >>= 7) out += static_cast<char>(value | 0x80);
  return out + static_cast<char>(value);
}

/// A field with a length, which may be false.
inline std::string field(uint32_t number, const std::string& bytes, std::optional<uint64_t> length = {}) {
  return varint(number << 3 | 2) + varint(length.value_or(bytes.size())) + bytes;
}

inline std::string text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Room for positions, aligned like a slot's, that detects writes past its end.
class Room {
 public:
  explicit Room(size_t bytes) : bytes_(bytes), memory_(bytes / sizeof(Line) + 2) { std::memset(end(), kMark, kMarked); }

  std::span<std::byte> ask() {
    ++asked_;
    return {begin(), bytes_};
  }
  int asked() const { return asked_; }
  bool holds(std::span<const std::byte> bytes) const {
    return bytes.empty() || (bytes.data() >= begin() && bytes.data() + bytes.size() <= begin() + bytes_);
  }
  bool is_intact() const {
    return std::all_of(end(), end() + kMarked, [](std::byte b) { return b == static_cast<std::byte>(kMark); });
  }

 private:
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  static constexpr int kMark = 0x5a;
  static constexpr size_t kMarked = 64;

  std::byte* begin() const { return const_cast<std::byte*>(memory_[0].bytes); }
  std::byte* end() const { return begin() + bytes_; }

  size_t bytes_;
  std::vector<Line> memory_;
  int asked_ = 0;
};

/// `block`: bytes that the stream gives at a time; 0: all. `meshes`: of the scene; none: the stream is not open yet.
inline DecodedRequest decode(const std::string& wire, Room& room, int block = 0, std::optional<size_t> meshes = 16) {
  google::protobuf::io::ArrayInputStream stream(wire.data(), static_cast<int>(wire.size()), block > 0 ? block : -1);
  return decode_request(stream, wire.size(), {meshes}, [&] { return room.ask(); });
}

inline void put_back(std::span<const std::byte> placed, std::string& otherwise) {
  if (placed.empty()) return;
  EXPECT_TRUE(otherwise.empty());
  otherwise = text(placed);
}

/// The request with its positions back in the message, and without unknown fields, as bytes.
inline std::string whole(const DecodedRequest& decoded) {
  pb::StreamFramesRequest message = decoded.message;
  for (size_t i = 0; i < decoded.placed.size(); ++i) {
    pb::MeshUpdate& update = *message.mutable_frame()->mutable_updates(static_cast<int>(i));
    put_back(decoded.placed[i].end, *update.mutable_positions());
    put_back(decoded.placed[i].start, *update.mutable_start_positions());
  }
  message.DiscardUnknownFields();
  return message.SerializeAsString();
}

enum class Verdict { kSame, kRefused, kHasBoth };

/// Expects the generated parser's result. kHasBoth: an opening and a frame, which we refuse.
inline Verdict expect_same(const std::string& wire, int block = 0) {
  const google::protobuf::LogSilencer no_words_on_strings_that_are_not_utf8;
  pb::StreamFramesRequest expected;
  const bool is_valid = expected.ParseFromString(wire);
  expected.DiscardUnknownFields();
  Room room(4096);
  try {
    const auto decoded = decode(wire, room, block);
    EXPECT_TRUE(is_valid) << testing::PrintToString(wire);
    EXPECT_EQ(whole(decoded), expected.SerializeAsString()) << testing::PrintToString(wire);
    EXPECT_EQ(decoded.placed.size(), static_cast<size_t>(decoded.message.frame().updates_size()));
    return Verdict::kSame;
  } catch (const InvalidInput& e) {
    const bool has_both = std::string(e.what()).find("must have one of them") != std::string::npos;
    EXPECT_TRUE(has_both || !is_valid) << e.what() << ": " << testing::PrintToString(wire);
    return has_both ? Verdict::kHasBoth : Verdict::kRefused;
  }
}

}  // namespace collided::server
