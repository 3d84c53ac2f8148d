#pragma once
// The StreamFrames calls: raw messages on completion queues of their own, whose threads take frames in and never run
// engine work. (The callback API is slower for large messages: more threads hand each one on.)

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/auth/authenticator.hpp"
#include "server/ops/metrics.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/service/raw_service.hpp"
#include "server/service/waiting_calls.hpp"

namespace collided::server {

class FrameCall;

/// What a StreamFrames call works with.
struct FrameCallParts {
  SceneHost& host;
  const Authenticator& authenticator;
  Metrics& metrics;
  WaitingCalls& waiting;
  uint64_t max_message_bytes;
  std::function<void(const std::string& peer)> fruitless;  ///< called for each that ends without having opened a stream
};

class FrameCalls {
 public:
  /// Before the server is built. `service` and `parts` outlive the calls.
  FrameCalls(grpc::ServerBuilder& builder, RawService& service, FrameCallParts parts);
  /// After stop(), or if the server was never built.
  ~FrameCalls();

  /// Once the server is built.
  void start();
  /// Ends calls that have not opened a stream yet; the host tells the others.
  void announce_stop();
  /// Calls in work.
  size_t open() const;
  /// Bytes of answers that clients have not taken yet.
  uint64_t outgoing_bytes() const;
  /// Waits for the last call. After the server's Shutdown.
  void stop();

 private:
  friend class FrameCall;

  void run();
  void add(const std::shared_ptr<FrameCall>& call);
  std::vector<std::shared_ptr<FrameCall>> calls() const;

  RawService& service_;
  const FrameCallParts parts_;
  std::unique_ptr<grpc::ServerCompletionQueue> queue_;
  std::vector<std::thread> threads_;
  mutable std::mutex mutex_;
  std::vector<std::weak_ptr<FrameCall>> calls_;  // guarded by mutex_
};

}  // namespace collided::server
