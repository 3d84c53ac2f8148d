// The frames of all streams as messages.

#include "client/measure/load/drive/messages.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include "client/app/input/mesh_input.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::cli::load {

namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

constexpr uint64_t kFirst = 1, kLater = 2;  // ids for make_frame

/// A frame's updates in wire format, without its id.
grpc::Slice updates_of(const Motion& motion, int frame, uint64_t id, const v1::SceneSpec& spec) {
  v1::Frame message = make_frame(motion.meshes, id, spec, motion.positions(frame));
  message.clear_frame_id();
  return grpc::Slice(message.SerializeAsString());
}

}  // namespace

Messages::Messages(const Motion& motion, const v1::SceneSpec& spec) {
  for (int i = 0; i < motion.frames; ++i) later_.push_back(updates_of(motion, i, kLater, spec));
  first_ = updates_of(motion, 0, kFirst, spec);
}

grpc::ByteBuffer Messages::frame(uint64_t id) const {
  const grpc::Slice& updates = id == 1 ? first_ : later_[place_in_motion(id - 1, later_.size())];
  uint8_t own[16];  // the field of the id
  uint8_t* end = CodedOutputStream::WriteTagToArray(
      WireFormatLite::MakeTag(v1::Frame::kFrameIdFieldNumber, WireFormatLite::WIRETYPE_VARINT), own);
  end = CodedOutputStream::WriteVarint64ToArray(id, end);
  const auto own_size = static_cast<size_t>(end - own);
  uint8_t head[32];
  uint8_t* at = CodedOutputStream::WriteTagToArray(
      WireFormatLite::MakeTag(v1::StreamFramesRequest::kFrameFieldNumber, WireFormatLite::WIRETYPE_LENGTH_DELIMITED),
      head);
  at = CodedOutputStream::WriteVarint64ToArray(own_size + updates.size(), at);
  at = std::copy(own, end, at);
  const grpc::Slice slices[] = {grpc::Slice(head, static_cast<size_t>(at - head)), updates};
  return grpc::ByteBuffer(slices, 2);
}

}  // namespace collided::cli::load
