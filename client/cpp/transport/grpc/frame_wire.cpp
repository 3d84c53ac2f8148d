// A frame as the bytes of a StreamFramesRequest: protobuf, encoded by hand because its own encoder copies.

#include "client/cpp/transport/grpc/frame_wire.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include "client/cpp/frame_options.hpp"

namespace collided::client {

namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

constexpr size_t kMinBorrowedBytes = 4096;  // copying less is cheaper than another piece

class Writer {
 public:
  Writer() : parts_(1) {}

  void varint(uint64_t value) {
    uint8_t bytes[10];
    const uint8_t* end = CodedOutputStream::WriteVarint64ToArray(value, bytes);
    parts_.back().head.append(reinterpret_cast<const char*>(bytes), static_cast<size_t>(end - bytes));
  }
  void tag(int field, WireFormatLite::WireType type) { varint(WireFormatLite::MakeTag(field, type)); }
  /// The head of a field of `size` bytes.
  void field(int number, size_t size) {
    tag(number, WireFormatLite::WIRETYPE_LENGTH_DELIMITED);
    varint(size);
  }
  void bytes_field(int number, std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    field(number, bytes.size());
    if (bytes.size() < kMinBorrowedBytes) {
      parts_.back().head.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      return;
    }
    parts_.back().borrowed = bytes;
    parts_.emplace_back();
  }
  void message(const google::protobuf::MessageLite& message) { message.AppendToString(&parts_.back().head); }
  std::vector<WirePart> take() { return std::move(parts_); }

 private:
  std::vector<WirePart> parts_;
};

size_t varint_size(uint64_t value) { return CodedOutputStream::VarintSize64(value); }
size_t field_size(size_t bytes) { return 1 + varint_size(bytes) + bytes; }
size_t bytes_size(std::span<const std::byte> bytes) { return bytes.empty() ? 0 : field_size(bytes.size()); }

std::span<const std::byte> bytes_of(const RigidMatrix* matrix) {
  return matrix ? std::as_bytes(std::span(*matrix)) : std::span<const std::byte>();
}

size_t rigid_size(const FrameUpdate& update) {
  return bytes_size(bytes_of(update.transform)) + bytes_size(bytes_of(update.start_transform));
}

size_t update_size(const FrameUpdate& update) {
  const size_t indices = bytes_size(update.indices), rigid = rigid_size(update);
  return (update.mesh ? 1 + varint_size(update.mesh) : 0) + (indices ? field_size(indices) : 0) +
         (rigid ? field_size(rigid) : 0) + bytes_size(update.start_positions) + bytes_size(update.positions);
}

void write_update(Writer& out, const FrameUpdate& update) {
  using v1::MeshUpdate;
  out.field(v1::Frame::kUpdatesFieldNumber, update_size(update));
  if (update.mesh) {
    out.tag(MeshUpdate::kMeshFieldNumber, WireFormatLite::WIRETYPE_VARINT);
    out.varint(update.mesh);
  }
  if (const size_t indices = bytes_size(update.indices)) {
    out.field(MeshUpdate::kSparseFieldNumber, indices);
    out.bytes_field(v1::SparseIndices::kIndicesFieldNumber, update.indices);
  }
  if (const size_t rigid = rigid_size(update)) {
    out.field(MeshUpdate::kRigidFieldNumber, rigid);
    out.bytes_field(v1::RigidTransform::kMatrixFieldNumber, bytes_of(update.transform));
    out.bytes_field(v1::RigidTransform::kStartMatrixFieldNumber, bytes_of(update.start_transform));
  }
  out.bytes_field(MeshUpdate::kStartPositionsFieldNumber, update.start_positions);
  out.bytes_field(MeshUpdate::kPositionsFieldNumber, update.positions);
}

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// Whether a FrameUpdate can express it.
bool is_plain(const v1::MeshUpdate& update) {
  const bool plain_indices =
      !update.has_sparse() || (!update.sparse().indices().empty() && !update.sparse().has_shared_indices());
  return plain_indices && !update.has_rigid() && !update.has_shared_positions() && !update.has_shared_start_positions();
}

FrameUpdate view_of(const v1::MeshUpdate& update) {
  return {.mesh = update.mesh(),
          .positions = bytes_of(update.positions()),
          .start_positions = bytes_of(update.start_positions()),
          .indices = bytes_of(update.sparse().indices())};
}

/// The frame without its plain updates.
v1::Frame head_of(const v1::Frame& frame) {
  v1::Frame head;
  copy_head(frame, head);
  for (const v1::MeshUpdate& update : frame.updates())
    if (!is_plain(update)) *head.add_updates() = update;
  return head;
}

}  // namespace

std::vector<WirePart> encode_frame(const v1::Frame& frame, std::span<const FrameUpdate> updates) {
  std::vector<FrameUpdate> all;
  for (const v1::MeshUpdate& update : frame.updates())
    if (is_plain(update)) all.push_back(view_of(update));
  all.insert(all.end(), updates.begin(), updates.end());
  const v1::Frame head = head_of(frame);
  size_t size = head.ByteSizeLong();
  for (const FrameUpdate& update : all) size += field_size(update_size(update));
  Writer out;
  out.field(v1::StreamFramesRequest::kFrameFieldNumber, size);
  out.message(head);
  for (const FrameUpdate& update : all) write_update(out, update);
  return out.take();
}

size_t size_of(std::span<const WirePart> parts) {
  size_t bytes = 0;
  for (const WirePart& part : parts) bytes += part.head.size() + part.borrowed.size();
  return bytes;
}

}  // namespace collided::client
