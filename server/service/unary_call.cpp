// A unary call as raw messages.
#include "server/service/unary_call.hpp"

#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <stdexcept>

#include "server/convert/convert.hpp"
#include "server/convert/wire_bounds.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

// That have not brought their message: few enough to cost little memory, more than honest clients begin at once.
constexpr size_t kMostSilent = 4096, kMostSilentOfClient = 1024;
constexpr double kSlowestBytes = 1 << 20;  // a second, of a message that is on its way

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
  await_message();
  StartRead(&bytes_);
} catch (...) {
  Finish(to_status(describe_current()));
}

// Of a message that is on its way nothing is seen until it is there: the largest has time to come over a slow network.
void UnaryCallBase::await_message() {
  const double seconds = parts_.host.limits().max_silent_seconds +
                         std::floor(static_cast<double>(parts_.max_message_bytes) / kSlowestBytes);
  const WaitRule rule{"the message of the call", seconds, kMostSilent, kMostSilentOfClient, source_of(context_.peer())};
  message_ = parts_.waiting.wait(rule, caller_.client,
                                 [this](const std::exception_ptr& why) { finish(to_status(describe(why))); });
}

void UnaryCallBase::OnReadDone(bool ok) {
  if (!message_->over()) return;  // the call has been ended
  message_.reset();
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
