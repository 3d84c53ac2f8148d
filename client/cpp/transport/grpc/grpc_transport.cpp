// A frame stream over one gRPC call. All events arrive in one queue, which any waiting thread may poll; a writer waits
// until its write has ended and gRPC has released the memory that it borrowed.

#include "client/cpp/transport/grpc/grpc_transport.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/byte_buffer.h>

#include <functional>
#include <utility>

#include "client/cpp/transport/grpc/deadline.hpp"

namespace collided::client {

namespace {

constexpr auto kMethod = "/collided.v1.CollisionService/StreamFrames";
constexpr std::chrono::milliseconds kPoll(1);

using Clock = std::chrono::steady_clock;

gpr_timespec queue_deadline(FrameTransport::Time deadline) {
  return deadline == FrameTransport::kNever ? no_deadline() : deadline_in(deadline - Clock::now());
}

}  // namespace

GrpcTransport::GrpcTransport(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
                             uint64_t max_message_bytes, std::chrono::milliseconds deadline)
    : channel_(std::move(channel)),
      context_(std::move(context)),
      max_message_bytes_(max_message_bytes),
      deadline_(deadline),
      call_(grpc::GenericStub(channel_).PrepareCall(context_.get(), kMethod, &queue_)) {}

GrpcTransport::~GrpcTransport() {
  cancel();
  queue_.Shutdown();
  void* tag;
  for (bool ok; queue_.Next(&tag, &ok);) continue;
}

void GrpcTransport::release(void* transport) {
  auto& self = *static_cast<GrpcTransport*>(transport);
  const std::lock_guard lock(self.mutex_);
  --self.borrowed_;
  self.polling_.notify();
}

grpc::ByteBuffer GrpcTransport::buffer_of(const std::vector<WirePart>& parts) {
  std::vector<grpc::Slice> slices;
  for (const WirePart& part : parts) {
    if (!part.head.empty()) slices.emplace_back(part.head);
    if (part.borrowed.empty()) continue;
    // gRPC only reads the memory, although its slices are not const.
    void* bytes = const_cast<std::byte*>(part.borrowed.data());
    slices.emplace_back(bytes, part.borrowed.size(), &GrpcTransport::release, this);
    const std::lock_guard lock(mutex_);
    ++borrowed_;
  }
  return grpc::ByteBuffer(slices.data(), slices.size());
}

/// Waits under the lock until `done`; false if the deadline passes first.
template <class Done>
bool GrpcTransport::await(LeaderFollowers::Lock& lock, const Done& done, Time deadline) {
  return polling_.await(lock, done, deadline, std::bind_front(&GrpcTransport::take_event, this));
}

/// Handles one event of the queue; false if none came by the deadline.
bool GrpcTransport::take_event(LeaderFollowers::Lock& lock, Time deadline) {
  lock.unlock();
  void* tag = nullptr;
  bool ok = false;
  const auto got = queue_.AsyncNext(&tag, &ok, queue_deadline(deadline));
  lock.lock();
  if (got == grpc::CompletionQueue::GOT_EVENT) *static_cast<Operation*>(tag) = {.is_pending = false, .is_ok = ok};
  return got != grpc::CompletionQueue::TIMEOUT;
}

/// Waits until no write is pending. False, and the end of the call, if the daemon does not take it in time.
bool GrpcTransport::await_write(LeaderFollowers::Lock& lock) {
  const auto is_written = [&] { return !write_.is_pending; };
  const Time now = Clock::now();
  if (await(lock, is_written, deadline_ < kNever - now ? now + deadline_ : kNever)) return true;
  is_late_ = true;
  lock.unlock();
  cancel();
  lock.lock();
  await(lock, is_written);
  return false;
}

/// Waits until no write is pending and gRPC has released what it borrowed, which it does soon after the write, without
/// an event.
void GrpcTransport::await_written(LeaderFollowers::Lock& lock) {
  await_write(lock);
  while (!await(
      lock, [&] { return borrowed_ == 0; }, Clock::now() + kPoll))
    continue;
}

/// Starts a write once the previous one has ended. False if no further write is allowed.
template <class Start>
bool GrpcTransport::write(const Start& start, bool is_last) {
  LeaderFollowers::Lock lock(mutex_);
  if (!await_write(lock) || is_closed_) return false;
  is_closed_ = is_last;
  write_.is_pending = true;
  ++starting_;
  lock.unlock();
  start();  // unlocked: gRPC may call release(), which locks, before this returns
  lock.lock();
  --starting_;
  return true;
}

bool GrpcTransport::open(const v1::OpenStream& open) {
  v1::StreamFramesRequest request;
  *request.mutable_open() = open;
  const grpc::Slice slice(request.SerializeAsString());
  const grpc::ByteBuffer buffer(&slice, 1);
  if (!write([&] { call_->StartCall(&write_); })) return false;
  return write([&] { call_->Write(buffer, &write_); });
}

bool GrpcTransport::send(const v1::Frame& frame, std::span<const FrameUpdate> updates) {
  const std::vector<WirePart> parts = encode_frame(frame, updates);
  if (const size_t bytes = size_of(parts); bytes > max_message_bytes_)
    throw Error(grpc::RESOURCE_EXHAUSTED, "frame is " + std::to_string(bytes) + " bytes; the daemon's limit is " +
                                              std::to_string(max_message_bytes_) + " (--max-message-mb)");
  grpc::ByteBuffer buffer = buffer_of(parts);
  const bool is_started = write([&] { call_->Write(buffer, grpc::WriteOptions().set_write_through(), &write_); });
  buffer.Clear();
  LeaderFollowers::Lock lock(mutex_);
  await_written(lock);
  return is_started && write_.is_ok;
}

FrameTransport::Arrival GrpcTransport::read(v1::StreamFramesResponse& response, Time deadline) {
  LeaderFollowers::Lock lock(mutex_);
  if (!std::exchange(is_reading_, true)) {
    read_.is_pending = true;
    lock.unlock();
    call_->Read(&incoming_, &read_);
    lock.lock();
  }
  if (!await(
          lock, [&] { return !read_.is_pending; }, deadline))
    return Arrival::kNothing;
  is_reading_ = false;
  lock.unlock();
  if (!read_.is_ok) return Arrival::kEnd;
  if (!grpc::SerializationTraits<v1::StreamFramesResponse>::Deserialize(&incoming_, &response).ok())
    throw Error(grpc::DATA_LOSS, "the daemon's message is not a StreamFramesResponse");
  return Arrival::kMessage;
}

std::span<const std::byte> GrpcTransport::shared(const v1::SharedRange& range) const {
  throw Error(grpc::DATA_LOSS, "contacts.shared names " + std::to_string(range.size()) +
                                   " bytes of shared memory; a gRPC stream has none");
}

void GrpcTransport::half_close() {
  constexpr bool kLast = true;
  if (!write([&] { call_->WritesDone(&write_); }, kLast)) return;
  LeaderFollowers::Lock lock(mutex_);
  await_write(lock);
}

// Unlocked, as for a write.
void GrpcTransport::cancel() {
  std::unique_lock lock(mutex_);
  const auto context = context_;
  lock.unlock();
  if (context) context->TryCancel();
}

/// Nothing else is pending. What gRPC had taken but not sent when the connection was lost, it releases with the call.
void GrpcTransport::end_call(LeaderFollowers::Lock& lock) {
  await(lock, [&] { return !write_.is_pending; });  // a write of another thread
  while (!await(
      lock, [&] { return starting_ == 0; }, Clock::now() + kPoll))
    continue;
  call_.reset();
  auto context = std::move(context_);
  lock.unlock();
  context.reset();
  lock.lock();
}

std::optional<Error> GrpcTransport::finish() {
  LeaderFollowers::Lock lock(mutex_);
  is_closed_ = true;
  finish_.is_pending = true;
  lock.unlock();
  grpc::Status status;
  call_->Finish(&status, &finish_);
  lock.lock();
  await(lock, [&] { return !finish_.is_pending; });
  end_call(lock);
  await_written(lock);
  if (is_late_)
    return Error(grpc::DEADLINE_EXCEEDED,
                 "the daemon took no message within " + std::to_string(deadline_.count()) + " ms (deadline)");
  return error_of(status);
}

}  // namespace collided::client
