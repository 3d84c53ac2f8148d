#pragma once
// One StreamFrames call: reads a frame only while credits are left, and answers in frame order.

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <mutex>

#include "server/scenes/scene_store.hpp"
#include "server/service/service_frame.hpp"
#include "server/service/status.hpp"

namespace collided::server {

class FrameStream final : public grpc::ServerBidiReactor<pb::StreamFramesRequest, pb::StreamFramesResponse>,
                          public std::enable_shared_from_this<FrameStream> {
 public:
  /// `held` lives as long as the call.
  FrameStream(SceneStore& scenes, uint32_t max_window, std::shared_ptr<void> held)
      : scenes_(scenes), max_window_(max_window), held_(std::move(held)) {}

  /// Keeps itself alive until gRPC is done with it.
  void start();
  /// Ends the call at once, instead of start().
  void refuse(const grpc::Status& status);
  /// Tells the client that the daemon stops; a stream that has not opened yet ends.
  void announce_stop(double seconds);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  using Request = pb::StreamFramesRequest;
  using Response = pb::StreamFramesResponse;
  using Time = std::chrono::steady_clock::time_point;

  // `_locked`: the caller holds mutex_.
  void open_locked(const pb::OpenStream& open);
  void submit_locked(std::shared_ptr<Request> request);
  void read_locked();
  void write_locked();
  void send_locked(Response response);
  void refuse_locked(uint64_t frame_id, const Failure& failure);
  void finish_locked(const grpc::Status& status);
  void finish_if_idle_locked();
  void refuse_for_queue(uint64_t frame_id);
  void work(const Request& request, Time arrival);
  void answer(uint64_t frame_id, FrameAnswer answer);

  SceneStore& scenes_;
  const uint32_t max_window_;
  const std::shared_ptr<void> held_;
  std::shared_ptr<FrameStream> self_;
  std::shared_ptr<Scene> scene_;  // set once, by the opening
  std::atomic<bool> cancelled_ = false;

  std::mutex mutex_;  // guards what follows
  std::shared_ptr<Request> incoming_;
  std::deque<Response> outgoing_;
  size_t queued_bytes_ = 0;  // of outgoing_
  uint32_t window_ = 0;
  uint32_t in_flight_ = 0;  // frames whose end has not been written yet
  bool reading_ = false, writing_ = false, read_all_ = false, finished_ = false;
};

}  // namespace collided::server
