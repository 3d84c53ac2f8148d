#pragma once
// One frame stream as a gRPC call whose events arrive in a queue that many streams share: no thread of its own, unlike
// client::FrameStream.

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>

#include <memory>

#include "collided/v1/collision_service.pb.h"

namespace collided::cli::load {

/// At most one write, or half-close, and one read are pending at a time. Not thread-safe.
class FrameCall {
 public:
  enum class Event { kStarted, kWritten, kRead, kHalfClosed, kFinished };
  /// What the queue hands out.
  struct Tag {
    Event event;
    void* owner;
  };

  FrameCall(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
            grpc::CompletionQueue& queue, void* owner);

  void start() { call_->StartCall(&started_); }
  void write(const grpc::ByteBuffer& message) {
    call_->Write(message, grpc::WriteOptions().set_write_through(), &written_);
  }
  void write(const v1::OpenStream& open);
  void read() { call_->Read(&incoming_, &read_); }
  /// The message that was read. False if it is none.
  bool parse(v1::StreamFramesResponse& message);
  void half_close() { call_->WritesDone(&half_closed_); }
  void finish() { call_->Finish(&status_, &finished_); }
  void cancel() { context_->TryCancel(); }
  const grpc::Status& status() const { return status_; }

 private:
  Tag started_, written_, read_, half_closed_, finished_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<grpc::ClientContext> context_;
  grpc::ByteBuffer incoming_;
  grpc::Status status_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
};

}  // namespace collided::cli::load
