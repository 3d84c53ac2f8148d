// A frame stream over one gRPC call. All events come through one queue, which the reader pumps; a writer waits until
// the reader has seen its write end and gRPC has let go of the memory that it lent.

#include "client/cpp/grpc_transport.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/byte_buffer.h>

#include <chrono>

namespace collided::client {

namespace {

constexpr auto kMethod = "/collided.v1.CollisionService/StreamFrames";
constexpr std::chrono::milliseconds kPoll(10);

void* tag_of(auto operation) { return reinterpret_cast<void*>(operation); }

}  // namespace

GrpcTransport::GrpcTransport(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
                             uint64_t max_message_bytes)
    : channel_(std::move(channel)),
      context_(std::move(context)),
      max_message_bytes_(max_message_bytes),
      call_(grpc::GenericStub(channel_).PrepareCall(context_.get(), kMethod, &queue_)) {}

GrpcTransport::~GrpcTransport() {
  context_->TryCancel();
  queue_.Shutdown();
  void* tag;
  for (bool ok; queue_.Next(&tag, &ok);) continue;
}

void GrpcTransport::release(void* transport) {
  auto& self = *static_cast<GrpcTransport*>(transport);
  const std::lock_guard lock(self.mutex_);
  --self.borrowed_;
  self.changed_.notify_all();
}

grpc::ByteBuffer GrpcTransport::buffer_of(const std::vector<WirePart>& parts) {
  std::vector<grpc::Slice> slices;
  for (const WirePart& part : parts) {
    if (!part.head.empty()) slices.emplace_back(part.head);
    if (part.borrowed.empty()) continue;
    // gRPC reads the memory only, though its slices are not const.
    void* bytes = const_cast<std::byte*>(part.borrowed.data());
    slices.emplace_back(bytes, part.borrowed.size(), &GrpcTransport::release, this);
    const std::lock_guard lock(mutex_);
    ++borrowed_;
  }
  return grpc::ByteBuffer(slices.data(), slices.size());
}

template <class Start>
bool GrpcTransport::begin_write(const Start& start) {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !is_writing_; });
    if (is_closed_) return false;
    is_writing_ = true;
  }
  start();  // without the lock: gRPC may let go of the memory before this returns
  return true;
}

bool GrpcTransport::end_write() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !is_writing_ && borrowed_ == 0; });
  return is_written_;
}

/// Takes events until the wanted one comes, and returns whether that one is good.
bool GrpcTransport::pump(Operation wanted) {
  void* tag;
  for (bool ok; queue_.Next(&tag, &ok);) {
    const auto operation = static_cast<Operation>(reinterpret_cast<intptr_t>(tag));
    if (operation == Operation::kWrite) {
      const std::lock_guard lock(mutex_);
      is_writing_ = false;
      is_written_ = ok;
      changed_.notify_all();
    }
    if (operation == wanted) return ok;
  }
  return false;
}

bool GrpcTransport::open(const v1::OpenStream& open) {
  v1::StreamFramesRequest request;
  *request.mutable_open() = open;
  const grpc::Slice slice(request.SerializeAsString());
  const grpc::ByteBuffer buffer(&slice, 1);
  is_writing_ = true;
  call_->StartCall(tag_of(Operation::kWrite));
  return pump(Operation::kWrite) && begin_write([&] { call_->Write(buffer, tag_of(Operation::kWrite)); });
}

bool GrpcTransport::send(const v1::Frame& frame, std::span<const FrameUpdate> updates) {
  const std::vector<WirePart> parts = encode_frame(frame, updates);
  if (const size_t bytes = size_of(parts); bytes > max_message_bytes_)
    throw Error(grpc::RESOURCE_EXHAUSTED, "frame is " + std::to_string(bytes) + " bytes; the daemon's limit is " +
                                              std::to_string(max_message_bytes_) + " (--max-message-mb)");
  grpc::ByteBuffer buffer = buffer_of(parts);
  const auto options = grpc::WriteOptions().set_write_through();
  const bool is_begun = begin_write([&] { call_->Write(buffer, options, tag_of(Operation::kWrite)); });
  buffer.Clear();
  return end_write() && is_begun;
}

bool GrpcTransport::read(v1::StreamFramesResponse& response) {
  grpc::ByteBuffer buffer;
  call_->Read(&buffer, tag_of(Operation::kRead));
  if (!pump(Operation::kRead)) return false;
  if (!grpc::SerializationTraits<v1::StreamFramesResponse>::Deserialize(&buffer, &response).ok())
    throw Error(grpc::DATA_LOSS, "the daemon's message is no StreamFramesResponse");
  return true;
}

std::span<const std::byte> GrpcTransport::shared(const v1::SharedRange& range) const {
  throw Error(grpc::DATA_LOSS, "contacts.shared names " + std::to_string(range.size()) +
                                   " bytes of shared memory; a gRPC stream has none");
}

void GrpcTransport::half_close() {
  if (begin_write([&] { call_->WritesDone(tag_of(Operation::kWrite)); })) end_write();
}

void GrpcTransport::cancel() { context_->TryCancel(); }

bool GrpcTransport::is_quiet() {
  const std::lock_guard lock(mutex_);
  return !is_writing_ && borrowed_ == 0;
}

std::optional<Error> GrpcTransport::finish() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  grpc::Status status;
  call_->Finish(&status, tag_of(Operation::kFinish));
  pump(Operation::kFinish);
  // The queue's events are what moves the connection: a writer still waits for it.
  while (!is_quiet()) {
    void* tag;
    bool ok;
    if (queue_.AsyncNext(&tag, &ok, std::chrono::system_clock::now() + kPoll) != grpc::CompletionQueue::GOT_EVENT)
      continue;
    const std::lock_guard lock(mutex_);
    is_writing_ = false;
    is_written_ = ok;
    changed_.notify_all();
  }
  return error_of(status);
}

}  // namespace collided::client
