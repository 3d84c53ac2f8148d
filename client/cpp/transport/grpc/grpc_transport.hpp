#pragma once
// A frame stream over one gRPC call. Messages are raw buffers: positions are sent in place.

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>

#include <memory>
#include <mutex>

#include "client/cpp/transport/frame_transport.hpp"
#include "client/cpp/transport/grpc/frame_wire.hpp"
#include "client/cpp/transport/leader_followers.hpp"

namespace collided::client {

class GrpcTransport final : public FrameTransport {
 public:
  /// The channel should be this stream's own: on a shared one, large frames hold up other calls. `context` has the
  /// call's metadata; frames of more than `max_message_bytes` are refused before they are sent. A daemon that takes no
  /// message for as long as `deadline` ends the stream.
  GrpcTransport(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
                uint64_t max_message_bytes, std::chrono::milliseconds deadline = std::chrono::seconds(60));
  ~GrpcTransport() override;

  bool open(const v1::OpenStream& open) override;
  bool send(const v1::Frame& frame, std::span<const FrameUpdate> updates) override;
  Arrival read(v1::StreamFramesResponse& response, Time deadline) override;
  std::span<const std::byte> shared(const v1::SharedRange& range) const override;
  void half_close() override;
  void cancel() override;
  std::optional<Error> finish() override;

 private:
  /// A write, a read or the finish; at most one of each is pending.
  struct Operation {
    bool is_pending = false;
    bool is_ok = false;  ///< how the last one ended
  };

  static void release(void* transport);
  grpc::ByteBuffer buffer_of(const std::vector<WirePart>& parts);
  template <class Start>
  bool write(const Start& start, bool is_last = false);
  template <class Done>
  bool await(LeaderFollowers::Lock& lock, const Done& done, Time deadline = kNever);
  bool await_write(LeaderFollowers::Lock& lock);
  bool take_event(LeaderFollowers::Lock& lock, Time deadline);
  void await_written(LeaderFollowers::Lock& lock);
  void end_call(LeaderFollowers::Lock& lock);

  std::shared_ptr<grpc::Channel> channel_;
  std::shared_ptr<grpc::ClientContext> context_;  ///< guarded by mutex_; none once finished
  uint64_t max_message_bytes_;
  const std::chrono::milliseconds deadline_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  grpc::ByteBuffer incoming_;  ///< the reader's; gRPC's while a read is pending
  std::mutex mutex_;           // guards what follows
  LeaderFollowers polling_;    ///< of the queue
  Operation write_, read_, finish_;
  bool is_reading_ = false;  ///< a read is pending, or its message has not been taken
  bool is_closed_ = false;   ///< no further write is allowed
  bool is_late_ = false;     ///< a write was not taken in time
  int starting_ = 0;         ///< threads that are about to start a write
  int borrowed_ = 0;         ///< pieces of the caller's memory that gRPC still holds
};

}  // namespace collided::client
