#pragma once
// Bounds a message's memory from its bytes, before it is parsed: two bytes on the wire can take a hundred in memory.

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>

#include <cstdint>
#include <string>
#include <utility>

namespace collided::server {

/// Maximum memory of a field besides its own bytes: an empty MeshUpdate, or an unknown field.
constexpr uint64_t kFieldBytes = 128;

/// Bytes of a packed array that take as much memory as a field: an element has a byte or more on the wire, and at most
/// eight in memory.
constexpr uint64_t kPackedBytesOfField = kFieldBytes / sizeof(uint64_t);

/// Maximum number of fields of a message for `meshes`, and for the numbers of so many worlds, with room for those of
/// later versions.
constexpr uint64_t max_fields(uint64_t meshes, uint64_t worlds = 0) {
  constexpr uint64_t kWorldBytes = 3;  // of a number below kMaxWorlds
  return 64 + 16 * meshes + worlds * kWorldBytes / kPackedBytesOfField;
}

/// Meshes of one edit.
constexpr uint64_t kMaxEditedMeshes = 256;
/// Meshes that a frame may be about, in a scene of so many, before it is known whether it has an edit.
constexpr uint64_t max_frame_meshes(uint64_t meshes) { return meshes + kMaxEditedMeshes; }

/// Maximum memory of a parsed message of `message_bytes`, for `meshes`.
constexpr uint64_t max_parsed_bytes(uint64_t message_bytes, uint64_t meshes) {
  return message_bytes + max_fields(meshes) * kFieldBytes;
}

/// Counts the fields of a message at all levels, including unknown ones, and packed arrays as the fields that take as
/// much memory. Strings and bytes are skipped, not copied.
class FieldCount {
 public:
  /// `what` names the message in refusals.
  FieldCount(std::string what, uint64_t max) : what_(std::move(what)), max_(max) {}

  /// Throws LimitExceeded past the maximum.
  void add(uint64_t fields = 1) {
    count_ += fields;
    if (count_ > max_) throw_too_many();
  }
  /// A whole message, up to the limit of `in`, which must have one. Throws InvalidInput for malformed bytes or
  /// nesting that is too deep, with a path that begins with `path`; LimitExceeded past the maximum.
  void add_message(google::protobuf::io::CodedInputStream& in, const google::protobuf::Descriptor& type,
                   std::string path);
  /// The same for bytes in memory.
  void add_message(const std::string& bytes, const google::protobuf::Descriptor& type, std::string path);

  uint64_t fields() const { return count_; }

 private:
  using Input = google::protobuf::io::CodedInputStream;
  using Type = google::protobuf::Descriptor;

  void add_fields(Input& in, const Type* type, int depth);
  void add_field(Input& in, uint32_t tag, const Type* type, int depth);
  void add_delimited(Input& in, const google::protobuf::FieldDescriptor* field, int depth);
  void add_group(Input& in, uint32_t start, int depth);
  [[noreturn]] void throw_malformed() const;
  [[noreturn]] void throw_too_many() const;

  std::string path_;
  const std::string what_;
  const uint64_t max_;
  uint64_t count_ = 0;
};

}  // namespace collided::server
