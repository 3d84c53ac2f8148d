#pragma once
// One StreamFrames call: reads a frame only while credits are left, and answers in the order of the frames.

#include <grpcpp/alarm.h>

#include <deque>
#include <optional>

#include "server/frames/decode.hpp"
#include "server/frames/intake.hpp"
#include "server/frames/session.hpp"
#include "server/frames/stream_flow.hpp"
#include "server/refusals/status.hpp"
#include "server/transport/grpc/caller.hpp"
#include "server/transport/grpc/encode.hpp"
#include "server/transport/grpc/frame_calls.hpp"

namespace collided::server {

class FrameCall final : public FrameSink, public std::enable_shared_from_this<FrameCall> {
 public:
  /// A completion-queue tag. Keeps the call alive until it arrives.
  class Tag {
   public:
    using Arrival = void (FrameCall::*)(bool ok);
    Tag(FrameCall& call, Arrival arrival) : call_(call), arrival_(arrival) {}
    /// Called when the operation is started.
    Tag* send();
    void arrive(bool ok);
    /// The tag will not arrive.
    void drop();

   private:
    FrameCall& call_;
    const Arrival arrival_;
    std::shared_ptr<FrameCall> alive_;
  };

  /// Waits for the next call.
  static void accept(FrameCalls& calls);

  void end_unopened();
  uint64_t outgoing_bytes() const;

  void opened(const Scene& scene) override;
  void answered(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame) override;
  void refused(uint64_t frame_id, const Failure& failure) override;
  void skipped(uint64_t frame_id) override;
  void draining(double seconds) override;
  void ended(const std::exception_ptr& why) override;

 private:
  explicit FrameCall(FrameCalls& calls) : calls_(calls), host_(calls.parts_.host), stream_(&context_) {}

  static void accept_next(FrameCalls& calls);
  void on_accepted(bool ok);
  void on_read(bool ok);
  void on_written(bool ok);
  void on_finished(bool) {}
  void on_gone(bool);
  void on_linger(bool ok);

  void await_opening();
  void handle(const grpc::ByteBuffer& bytes);
  void take(const grpc::ByteBuffer& bytes);
  Expected expected() const;
  DecodedRequest decode(const grpc::ByteBuffer& bytes, IncomingFrame& incoming) const;
  void open(const pb::OpenStream& open);
  void take_ticket(const Scene& scene, const std::string& resume_token, uint32_t window);
  void submit(IncomingFrame incoming);
  void take_outcome(uint64_t frame_id);
  void fail();
  void send(const pb::StreamFramesResponse& response);
  void send(std::vector<EncodedMessage> messages);
  void tell_end(const grpc::Status& status) const;

  // `_locked`: the caller holds mutex_.
  void read_locked();
  void write_locked();
  void end_locked(const grpc::Status& status);
  void abandon_locked();
  void finish_locked();
  void drop_outgoing_locked();
  void end_if_complete_locked();

  FrameCalls& calls_;
  SceneHost& host_;
  grpc::ServerContext context_;
  grpc::ServerAsyncReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer> stream_;
  grpc::ByteBuffer incoming_;  // of the pending read
  grpc::Alarm linger_;
  Tag accepted_{*this, &FrameCall::on_accepted}, read_{*this, &FrameCall::on_read},
      written_{*this, &FrameCall::on_written}, finished_{*this, &FrameCall::on_finished},
      gone_{*this, &FrameCall::on_gone}, lingered_{*this, &FrameCall::on_linger};

  Caller caller_;  // set before the first read

  mutable std::mutex mutex_;  // guards what follows
  std::shared_ptr<FrameSession> session_;
  std::unique_ptr<WaitingCalls::Wait> opening_;  // until the opening has arrived
  std::shared_ptr<void> ticket_;                 // counts the stream as open
  std::deque<EncodedMessage> outgoing_;
  size_t outgoing_bytes_ = 0;
  StreamFlow flow_;                     // an answer has left once it is fully written
  std::optional<grpc::Status> status_;  // of the call, once decided
  bool is_reading_ = false, is_writing_ = false, is_finishing_ = false;
  bool is_abandoned_ = false;
};

}  // namespace collided::server
