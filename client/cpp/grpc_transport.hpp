#pragma once
// A frame stream over one gRPC call. Messages go and come as raw buffers: positions are sent from where they lie.

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>

#include <condition_variable>
#include <memory>
#include <mutex>

#include "client/cpp/frame_transport.hpp"
#include "client/cpp/frame_wire.hpp"

namespace collided::client {

class GrpcTransport final : public FrameTransport {
 public:
  /// The channel should be this stream's own: on a shared one, large frames hold up other calls. `context` has the
  /// call's metadata; messages above `max_message_bytes` are refused before they are sent.
  GrpcTransport(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
                uint64_t max_message_bytes);
  ~GrpcTransport() override;

  bool open(const v1::OpenStream& open) override;
  bool send(const v1::Frame& frame, std::span<const FrameUpdate> updates) override;
  bool read(v1::StreamFramesResponse& response) override;
  std::span<const std::byte> shared(const v1::SharedRange& range) const override;
  void half_close() override;
  void cancel() override;
  std::optional<Error> finish() override;

 private:
  enum class Operation : intptr_t { kWrite = 1, kRead, kFinish };

  static void release(void* transport);
  grpc::ByteBuffer buffer_of(const std::vector<WirePart>& parts);
  template <class Start>
  bool begin_write(const Start& start);
  bool end_write();
  bool pump(Operation wanted);
  bool is_quiet();

  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<grpc::ClientContext> context_;
  uint64_t max_message_bytes_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_writing_ = false;  ///< one write at a time; the reader sees it end
  bool is_written_ = false;  ///< how the last one ended
  bool is_closed_ = false;   ///< no write may begin any more
  int borrowed_ = 0;         ///< pieces of the caller's memory that gRPC still holds
};

}  // namespace collided::client
