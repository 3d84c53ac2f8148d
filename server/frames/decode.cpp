// Decodes a request of the frame stream.
#include "server/frames/decode.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <climits>
#include <optional>
#include <string>
#include <utility>

#include "gpu/detector.hpp"
#include "server/convert/wire_bounds.hpp"
#include "server/errors.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;
using google::protobuf::io::CodedOutputStream;
using google::protobuf::io::StringOutputStream;

constexpr size_t kAlignment = 16;
constexpr uint32_t kFewBytes = 64;  // stay in the message
constexpr int kMaxTagBytes = 5, kMaxSizeBytes = 5;
constexpr int kMaxDepth = 100;  // of groups within groups, as the generated code has it

constexpr uint32_t tag_of(int field) {
  return WireFormatLite::MakeTag(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED);
}

[[noreturn]] void throw_malformed(const char* what) {
  throw InvalidInput(what, std::string(what) + " is cut off or malformed: its bytes are not such a message");
}

// 0 at the end of the message. Nothing for a tag that the generated code refuses; ReadTag() alone would truncate it.
std::optional<uint32_t> read_tag(CodedInputStream& in) {
  const int begin = in.CurrentPosition();
  const uint32_t tag = in.ReadTag();
  if (in.CurrentPosition() - begin > kMaxTagBytes) return {};
  return tag;
}

// The same for the length of what follows; ReadVarintSizeAsInt() alone would take ten bytes.
std::optional<int> read_size(CodedInputStream& in) {
  const int begin = in.CurrentPosition();
  int size = 0;
  if (!in.ReadVarintSizeAsInt(&size) || in.CurrentPosition() - begin > kMaxSizeBytes) return {};
  return size;
}

bool copy_field(CodedInputStream& in, uint32_t tag, CodedOutputStream& out, int depth = kMaxDepth);

// Up to the tag that ends the group.
bool copy_group(CodedInputStream& in, uint32_t tag, CodedOutputStream& out, int depth) {
  out.WriteTag(tag);
  while (const std::optional<uint32_t> next = read_tag(in)) {
    if (WireFormatLite::GetTagWireType(*next) == WireFormatLite::WIRETYPE_END_GROUP) {
      out.WriteTag(*next);
      return WireFormatLite::GetTagFieldNumber(*next) == WireFormatLite::GetTagFieldNumber(tag);
    }
    if (*next == 0 || !copy_field(in, *next, out, depth)) return false;
  }
  return false;
}

// Refuses what the generated code refuses; SkipField() alone would truncate lengths, and tags in groups, to 32 bits.
bool copy_field(CodedInputStream& in, uint32_t tag, CodedOutputStream& out, int depth) {
  const auto type = WireFormatLite::GetTagWireType(tag);
  if (type == WireFormatLite::WIRETYPE_START_GROUP)
    return WireFormatLite::GetTagFieldNumber(tag) != 0 && depth > 0 && copy_group(in, tag, out, depth - 1);
  if (type != WireFormatLite::WIRETYPE_LENGTH_DELIMITED) return WireFormatLite::SkipField(&in, tag, &out);
  const std::optional<int> size = read_size(in);
  std::string bytes;
  if (WireFormatLite::GetTagFieldNumber(tag) == 0 || !size || !in.ReadString(&bytes, *size)) return false;
  out.WriteTag(tag);
  out.WriteVarint32(static_cast<uint32_t>(*size));
  out.WriteString(bytes);
  return true;
}

[[noreturn]] void throw_too_many_updates(const std::string& path, size_t meshes) {
  throw InvalidInput(
      path + ".updates",
      fmt::format("{}.updates has more than {} entries, the number of the scene's meshes", path, meshes));
}

// An edit may add meshes; the engine knows how many there are then.
bool has_too_many_updates(const pb::Frame& frame, size_t meshes) {
  return static_cast<size_t>(frame.updates_size()) > (frame.has_edit() ? max_frame_meshes(meshes) : meshes);
}

// The length of what follows, all of which is within the message.
int read_size_within(CodedInputStream& in, const char* what) {
  const std::optional<int> size = read_size(in);
  if (!size || in.BytesUntilLimit() < *size) throw_malformed(what);
  return *size;
}

// Reads a nested message to its end with `decode`.
template <class Decode>
void read_nested(CodedInputStream& in, const char* what, const Decode& decode) {
  const auto limit = in.PushLimit(read_size_within(in, what));
  decode();
  in.PopLimit(limit);
}

// Stops reading a frame that is refused, now that its id is known.
struct Stopped {};

class Decoder {
 public:
  Decoder(CodedInputStream& in, const Expected& expected, const std::function<std::span<std::byte>()>& room)
      : in_(in),
        meshes_(expected.meshes),
        count_("request", max_fields(most_updates(), expected.worlds)),
        ask_for_room_(room) {}

  DecodedRequest decode() try {
    const std::string remaining = remaining_fields("request", [&](uint32_t tag) {
      if (tag != tag_of(pb::StreamFramesRequest::kFrameFieldNumber)) return false;
      if (!meshes_) throw FailedPrecondition("open", "the first request of a stream must be `open`");
      read_nested(in_, "frame", [&] { decode_frame(*out_.message.mutable_frame()); });
      return true;
    });
    pb::StreamFramesRequest others;
    merge(others, remaining, "request");
    if (!out_.message.has_frame())
      out_.message = std::move(others);
    else if (others.request_case() != pb::StreamFramesRequest::REQUEST_NOT_SET)
      throw InvalidInput("request", "request has `open` and `frame`, but must have one of them");
    return std::move(out_);
  } catch (const Stopped&) {
    return std::move(out_);
  }

 private:
  // The fields of a message that `take` does not consume, serialized as a separate message.
  template <class Take>
  std::string remaining_fields(const char* what, const Take& take) {
    std::string bytes;
    {
      StringOutputStream stream(&bytes);
      CodedOutputStream out(&stream);
      for (;;) {
        const std::optional<uint32_t> tag = read_tag(in_);
        if (!tag) throw_malformed(what);
        if (*tag == 0) break;
        count_.add();
        if (!take(*tag) && !copy_field(in_, *tag, out)) throw_malformed(what);
        if (out_.refusal) break;
      }
      out.Trim();
    }
    if (!out_.refusal && !in_.ConsumedEntireMessage()) throw_malformed(what);
    return bytes;
  }

  void merge(google::protobuf::Message& message, const std::string& bytes, const char* what) {
    count_.add_message(bytes, *message.GetDescriptor(), what);
    if (!message.MergeFromString(bytes)) throw_malformed(what);
  }

  void decode_frame(pb::Frame& frame) {
    const std::string remaining = remaining_fields("frame", [&](uint32_t tag) {
      if (tag != tag_of(pb::Frame::kUpdatesFieldNumber)) return false;
      if (static_cast<size_t>(frame.updates_size()) == most_updates()) {
        out_.refusal = too_many_updates();
        return true;
      }
      read_nested(in_, "frame.updates", [&] { decode_update(*frame.add_updates()); });
      return true;
    });
    merge(frame, remaining, "frame");
    if (!out_.refusal && has_too_many_updates(frame, *meshes_)) out_.refusal = too_many_updates();
    if (!out_.refusal) return;
    if (frame.frame_id() == 0) std::rethrow_exception(out_.refusal);  // no id to answer under
    throw Stopped();
  }

  uint64_t most_updates() const { return meshes_ ? max_frame_meshes(*meshes_) : 0; }
  std::exception_ptr too_many_updates() const {
    try {
      throw_too_many_updates("frame", *meshes_);
    } catch (...) {
      return std::current_exception();
    }
  }

  void decode_update(pb::MeshUpdate& update) {
    PlacedPositions placed;
    const std::string remaining = remaining_fields("frame.updates", [&](uint32_t tag) {
      if (tag == tag_of(pb::MeshUpdate::kPositionsFieldNumber))
        return read_bytes(placed.end, *update.mutable_positions());
      if (tag == tag_of(pb::MeshUpdate::kStartPositionsFieldNumber))
        return read_bytes(placed.start, *update.mutable_start_positions());
      return false;
    });
    merge(update, remaining, "frame.updates");
    out_.placed.push_back(placed);
  }

  // Of a repeated occurrence the last one counts, as protobuf requires.
  bool read_bytes(std::span<const std::byte>& placed, std::string& otherwise) {
    const int size = read_size_within(in_, "frame.updates");
    placed = {};
    otherwise.clear();
    const auto bytes = static_cast<size_t>(size);
    if (bytes <= kFewBytes || !fits(bytes)) {
      if (!in_.ReadString(&otherwise, size)) throw_malformed("frame.updates");
      return true;
    }
    const auto to = room_->subspan(used_, bytes);
    if (!in_.ReadRaw(to.data(), size)) throw_malformed("frame.updates");
    used_ += (bytes + kAlignment - 1) / kAlignment * kAlignment;
    placed = to;
    return true;
  }

  bool fits(size_t bytes) {
    if (!room_) room_ = ask_for_room_();
    return used_ <= room_->size() && bytes <= room_->size() - used_;
  }

  CodedInputStream& in_;
  const std::optional<size_t> meshes_;
  FieldCount count_;
  const std::function<std::span<std::byte>()>& ask_for_room_;
  std::optional<std::span<std::byte>> room_;
  size_t used_ = 0;
  DecodedRequest out_;
};

}  // namespace

DecodedRequest decode_request(google::protobuf::io::ZeroCopyInputStream& wire, size_t bytes, const Expected& expected,
                              const std::function<std::span<std::byte>()>& room) {
  CodedInputStream in(&wire);
  in.PushLimit(static_cast<int>(std::min<size_t>(bytes, INT_MAX)));  // false sizes are detected before they are used
  return Decoder(in, expected, room).decode();
}

void check_update_count(const pb::Frame& frame, size_t meshes, const char* path) {
  if (has_too_many_updates(frame, meshes)) throw_too_many_updates(path, meshes);
}

pb::Frame parse_bounded_frame(const std::string& bytes, size_t meshes, size_t worlds, const char* path) {
  FieldCount(path, max_fields(max_frame_meshes(meshes), worlds)).add_message(bytes, *pb::Frame::descriptor(), path);
  pb::Frame frame;
  if (!frame.ParseFromString(bytes)) throw_malformed(path);
  check_update_count(frame, meshes, path);
  return frame;
}

}  // namespace collided::server
