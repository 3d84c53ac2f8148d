// Writes a recording.

#include "client/cli/recording/writer.hpp"

#include <stdexcept>

#include "client/cli/recording/format.hpp"

namespace collided::cli {

namespace {

std::string varint(uint64_t x) {
  std::string out;
  for (; x >= 0x80; x >>= 7) out += static_cast<char>(0x80 | (x & 0x7f));
  return out + static_cast<char>(x);
}

}  // namespace

RecordingWriter::RecordingWriter(const std::string& file, v1::SceneSpec spec, std::span<const client::MeshInput> meshes)
    : file_(file), out_(file) {
  out_.write(kRecordingHeader.data(), kRecordingHeader.size());
  for (const client::MeshInput& mesh : meshes) *spec.add_meshes() = client::edited_mesh(0, mesh).spec();
  add("scene", spec);
}

void RecordingWriter::add(const std::string& what, const google::protobuf::MessageLite& message) {
  const uint64_t bytes = message.ByteSizeLong();
  if (bytes > kMaxRecordedBytes)
    throw std::runtime_error(file_ + ": a " + what + " of " + std::to_string(bytes) +
                             " bytes cannot be recorded; the limit is " + std::to_string(kMaxRecordedBytes));
  const std::string length = varint(bytes), text = message.SerializeAsString();
  out_.write(length.data(), length.size());
  out_.write(text.data(), text.size());
}

void RecordingWriter::finish() {
  out_.write("", 1);
  out_.finish();
}

}  // namespace collided::cli
