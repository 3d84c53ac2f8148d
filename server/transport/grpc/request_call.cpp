// A call that begins with one message of its client.
#include "server/transport/grpc/request_call.hpp"

#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "server/convert/meshes.hpp"
#include "server/convert/wire_bounds.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

// Calls whose message has not arrived: few enough to cost little memory, more than honest clients start at once.
constexpr size_t kMaxSilent = 4096, kMaxSilentOfClient = 1024;
constexpr double kMinBytesPerSecond = 1 << 20;  // of an arriving message

uint64_t count_fields(const grpc::ByteBuffer& bytes, const google::protobuf::Descriptor& type) {
  grpc::ByteBuffer copy(bytes);  // copies references only
  grpc::ProtoBufferReader reader(&copy);
  google::protobuf::io::CodedInputStream in(&reader);
  in.PushLimit(static_cast<int>(bytes.Length()));
  FieldCount count(type.name(), max_fields(kMaxMeshes));
  count.add_message(in, type, type.name());
  return count.fields();
}

}  // namespace

uint64_t decode_budget_bytes(const Limits& limits) {
  return std::max(limits.max_decode_bytes, 2 * max_parsed_bytes(limits.max_message_bytes, kMaxMeshes));
}

void check_message_size(uint64_t bytes, uint64_t max) {
  if (bytes > max)
    throw LimitExceeded("", fmt::format("the message has {} bytes, more than max_message_bytes, {} (option "
                                        "max-message-mb)",
                                        bytes, max));
}

std::shared_ptr<void> parse_bounded(const grpc::ByteBuffer& bytes, const Client& client, const CallParts& parts,
                                    google::protobuf::Message& message) {
  check_message_size(bytes.Length(), parts.max_message_bytes);
  const auto& type = *message.GetDescriptor();
  auto share = parts.budget.take(client, bytes.Length() + count_fields(bytes, type) * kFieldBytes);
  grpc::ByteBuffer copy(bytes);
  grpc::ProtoBufferReader reader(&copy);
  if (!message.ParseFromZeroCopyStream(&reader))
    throw InvalidInput(type.name(), type.name() + " is malformed: its bytes are not such a message");
  return share;
}

grpc::ByteBuffer to_bytes(const google::protobuf::Message& message) {
  grpc::ByteBuffer bytes;
  grpc::ProtoBufferWriter writer(&bytes, grpc::kProtoBufferWriterMaxBufferLength,
                                 static_cast<int>(message.ByteSizeLong()));
  if (!message.SerializeToZeroCopyStream(&writer)) throw std::runtime_error("the answer cannot be serialized");
  return bytes;
}

void RequestCall::begin() try {
  caller_.ids = ids_of(context_.client_metadata());  // even for a call that is refused
  caller_ = identify(context_, parts_.authenticator);
  await_message();
  StartRead(&bytes_);
} catch (...) {
  finish(to_status(describe_current()));
}

// gRPC shows nothing of a message before it is complete: the largest one gets time to arrive over a slow network.
void RequestCall::await_message() {
  const double seconds = parts_.host.limits().max_silent_seconds +
                         std::floor(static_cast<double>(parts_.max_message_bytes) / kMinBytesPerSecond);
  const WaitRule rule{"the message of the call", seconds, kMaxSilent, kMaxSilentOfClient, source_of(context_.peer())};
  message_ = parts_.waiting.wait(rule, caller_.client,
                                 [this](const std::exception_ptr& why) { finish(to_status(describe(why))); });
}

void RequestCall::OnReadDone(bool ok) {
  if (!message_->finish()) return;  // the call has been ended
  message_.reset();
  guard(*this, [&] {
    if (!ok) throw InvalidInput("request", "request is missing: the call had no message");
    check_message_size(bytes_.Length(), parts_.max_message_bytes);
    share_ = parts_.budget.take(caller_.client, bytes_.Length());  // so that few bytes wait for their client's turn
    parts_.work.post(caller_.client->turn_path(), [this] { take_message(); });
  });
}

// A call that was cancelled meanwhile runs all the same: clients that end at once delete their scenes and do not wait.
void RequestCall::take_message() {
  guard(*this, [&] {
    share_.reset();
    share_ = parse_bounded(bytes_, caller_.client, parts_, request_message());
    bytes_.Clear();
    answer();
  });
}

}  // namespace collided::server
