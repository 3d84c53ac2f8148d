#pragma once
// What a message would unfold to, counted on its bytes before anything of it is parsed: two bytes on the wire can take
// a hundred in memory.

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>

#include <cstdint>
#include <string>
#include <utility>

namespace collided::server {

/// Memory that a field takes at most beside its own bytes: an empty MeshUpdate, or an unknown field.
constexpr uint64_t kFieldBytes = 128;

/// Fields of a message for so many meshes at most, with room for those of later versions.
constexpr uint64_t most_fields(uint64_t meshes) { return 64 + 16 * meshes; }

/// Counts the fields of a message on all its levels, unknown ones and the elements of packed arrays among them. Strings
/// and bytes are skipped, not copied.
class FieldCount {
 public:
  /// `what` names the message in refusals.
  FieldCount(std::string what, uint64_t most) : what_(std::move(what)), most_(most) {}

  /// Throws LimitExceeded past the most.
  void add(uint64_t fields = 1) {
    count_ += fields;
    if (count_ > most_) throw_too_many();
  }
  /// All of a message up to the limit of `in`, which must have one. Throws InvalidInput for bytes that are no such
  /// message, and for one that nests too deeply, with its path, which begins with `path`; LimitExceeded past the most.
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
  const uint64_t most_;
  uint64_t count_ = 0;
};

}  // namespace collided::server
