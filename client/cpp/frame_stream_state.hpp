#pragma once
// What a FrameStream holds; Client makes it.

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "client/cpp/frame_stream.hpp"
#include "collided/v1/collision_service.grpc.pb.h"

namespace collided::client {

struct FrameStream::State {
  using Call = grpc::ClientReaderWriter<v1::StreamFramesRequest, v1::StreamFramesResponse>;

  State(v1::CollisionService::Stub& stub, const std::string& scene_id, uint32_t window, uint64_t max_message_bytes);
  ~State();
  void read_all();
  void take(v1::StreamFramesResponse& response);
  void complete(uint64_t frame_id);
  /// Needs the mutex. Why the stream ended, as an Error.
  [[noreturn]] void throw_ended() const;

  std::shared_ptr<grpc::Channel> channel;  ///< keeps the connection while the stream lives
  grpc::ClientContext context;
  std::unique_ptr<Call> call;
  uint64_t max_message_bytes;
  v1::StreamOpened opened;
  std::mutex mutex;
  std::condition_variable changed;
  std::map<uint64_t, FrameOutput> partial;
  std::deque<FrameOutput> ready;
  uint64_t in_flight = 0;
  bool ended = false;
  bool half_closed = false;
  grpc::Status status;
  std::thread reader;
};

}  // namespace collided::client
