#pragma once
// A StreamFrames call with a deadline, one message at a time.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/support/calls.hpp"

namespace collided::test {

/// The answer to one frame.
struct Answer {
  std::vector<pb::ContactChunk> chunks;
  std::optional<pb::FrameDone> done;
  std::optional<pb::FrameError> error;
  bool skipped = false;
  bool ended = false;  ///< the stream ended instead

  /// All contacts, for comparisons.
  std::string contacts() const {
    std::string bytes;
    for (const auto& chunk : chunks) bytes += chunk.elements() + chunk.toi() + chunk.distance() + chunk.flags();
    return bytes;
  }
};

class Stream {
 public:
  Stream(Stub& stub, const std::string& scene_id, uint32_t window = 0, const std::string& resume_token = "",
         pb::DeliveryPolicy delivery = pb::DELIVERY_POLICY_UNSPECIFIED)
      : Stream(stub, opening(scene_id, window, resume_token, delivery)) {}
  Stream(Stub& stub, const pb::StreamFramesRequest& request) {
    set_deadline(context_);
    call_ = stub.StreamFrames(&context_);
    call_->Write(request);
    pb::StreamFramesResponse response;
    if (call_->Read(&response) && response.has_opened()) opened_ = response.opened();
  }
  ~Stream() {
    if (!call_) return;
    context_.TryCancel();
    finish();
  }

  const std::optional<pb::StreamOpened>& opened() const { return opened_; }
  /// False once the stream is over.
  bool send(const pb::Frame& frame) {
    pb::StreamFramesRequest request;
    *request.mutable_frame() = frame;
    return call_->Write(request);
  }
  /// All of one frame's answer; notices of a stop in between are counted.
  Answer receive(uint64_t frame_id) {
    Answer answer;
    pb::StreamFramesResponse response;
    while (call_->Read(&response)) {
      if (response.has_draining()) {
        ++drainings_;
        continue;
      }
      EXPECT_EQ(response.frame_id(), frame_id);
      if (response.has_contacts()) answer.chunks.push_back(response.contacts());
      answer.chunks.insert(answer.chunks.end(), response.done().contacts().begin(), response.done().contacts().end());
      if (response.has_done()) answer.done = response.done();
      if (response.has_error()) answer.error = response.error();
      answer.skipped = response.has_skipped();
      if (answer.done || answer.error || answer.skipped) return answer;
    }
    answer.ended = true;
    return answer;
  }
  Answer ask(const pb::Frame& frame) {
    send(frame);
    return receive(frame.frame_id());
  }
  bool read(pb::StreamFramesResponse* response) { return call_->Read(response); }
  int drainings() const { return drainings_; }
  void cancel() { context_.TryCancel(); }
  grpc::Status finish() {
    call_->WritesDone();
    return wait_end();
  }
  /// How the daemon ends the stream, while this side keeps it open.
  grpc::Status wait_end() {
    pb::StreamFramesResponse response;
    while (call_->Read(&response)) continue;
    auto status = call_->Finish();
    call_.reset();
    return status;
  }

  static pb::StreamFramesRequest opening(const std::string& scene_id, uint32_t window = 0,
                                         const std::string& resume_token = "",
                                         pb::DeliveryPolicy delivery = pb::DELIVERY_POLICY_UNSPECIFIED) {
    pb::StreamFramesRequest request;
    request.mutable_open()->set_scene_id(scene_id);
    request.mutable_open()->set_window(window);
    request.mutable_open()->set_resume_token(resume_token);
    request.mutable_open()->set_delivery(delivery);
    return request;
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<pb::StreamFramesRequest, pb::StreamFramesResponse>> call_;
  std::optional<pb::StreamOpened> opened_;
  int drainings_ = 0;
};

}  // namespace collided::test
