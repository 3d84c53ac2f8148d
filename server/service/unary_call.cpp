// A unary call as raw messages.
#include "server/service/unary_call.hpp"

#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>
#include <spdlog/fmt/fmt.h>

#include <stdexcept>

#include "server/convert/convert.hpp"
#include "server/convert/wire_bounds.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

uint64_t count_fields(const grpc::ByteBuffer& bytes, const google::protobuf::Descriptor& type) {
  grpc::ByteBuffer copy(bytes);  // of references
  grpc::ProtoBufferReader reader(&copy);
  google::protobuf::io::CodedInputStream in(&reader);
  in.PushLimit(static_cast<int>(bytes.Length()));
  FieldCount count(type.name(), most_fields(kMaxMeshes));
  count.add_message(in, type, type.name());
  return count.fields();
}

}  // namespace

void check_message_size(uint64_t bytes, uint64_t most) {
  if (bytes > most)
    throw LimitExceeded("", fmt::format("the message has {} bytes, more than max_message_bytes, {} (option "
                                        "max-message-mb)",
                                        bytes, most));
}

std::shared_ptr<void> parse_bounded(const grpc::ByteBuffer& bytes, const Client& client, const CallParts& parts,
                                    google::protobuf::Message& message) {
  check_message_size(bytes.Length(), parts.max_message_bytes);
  const auto& type = *message.GetDescriptor();
  auto share = parts.budget.take(client, bytes.Length() + count_fields(bytes, type) * kFieldBytes);
  grpc::ByteBuffer copy(bytes);
  grpc::ProtoBufferReader reader(&copy);
  if (!message.ParseFromZeroCopyStream(&reader))
    throw InvalidInput(type.name(), type.name() + " is malformed: its bytes are no such message");
  return share;
}

grpc::ByteBuffer to_bytes(const google::protobuf::Message& message) {
  grpc::ByteBuffer bytes;
  grpc::ProtoBufferWriter writer(&bytes, grpc::kProtoBufferWriterMaxBufferLength,
                                 static_cast<int>(message.ByteSizeLong()));
  if (!message.SerializeToZeroCopyStream(&writer)) throw std::runtime_error("the answer cannot be serialized");
  return bytes;
}

void UnaryCallBase::begin() try {
  caller_ = identify(context_, parts_.authenticator);
  StartRead(&bytes_);
} catch (...) {
  Finish(to_status(describe_current()));
}

void UnaryCallBase::OnReadDone(bool ok) {
  guard(*this, [&] {
    if (!ok) throw InvalidInput("request", "request is missing: the call brought no message");
    share_ = parse_bounded(bytes_, caller_.client, parts_, request_message());
    bytes_.Clear();
    answer();
  });
}

// The client takes its answer when it likes: until then there are its bytes alone.
void UnaryCallBase::finish() {
  auto answer_share = parts_.budget.take(caller_.client, response_message().ByteSizeLong());
  bytes_ = to_bytes(response_message());
  forget_messages();
  share_ = std::move(answer_share);
  StartWriteAndFinish(&bytes_, grpc::WriteOptions(), grpc::Status::OK);
}

}  // namespace collided::server
