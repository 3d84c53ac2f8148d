#pragma once
// The StreamFrames calls: raw messages on their own completion queue, whose threads read frames and never run engine
// work. Large ones are read in turns of their client. (The callback API is slower for large messages: it passes each
// one through more threads.)

#include <grpcpp/grpcpp.h>

#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/auth/authenticator.hpp"
#include "server/limits/client_work.hpp"
#include "server/limits/waiting_calls.hpp"
#include "server/ops/metrics.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/transport/grpc/call_watch.hpp"
#include "server/transport/grpc/raw_service.hpp"

namespace collided::server {

class FrameCall;

/// Shared by all StreamFrames calls.
struct FrameCallParts {
  SceneHost& host;
  const Authenticator& authenticator;
  Metrics& metrics;
  WaitingCalls& waiting;
  ClientWork& work;
  uint64_t max_message_bytes;
  const CallEvents& events;  ///< a call is abandoned if it ends before it opens a stream
};

class FrameCalls {
 public:
  /// Before the server is built. `service` and `parts` outlive the calls.
  FrameCalls(grpc::ServerBuilder& builder, RawService& service, FrameCallParts parts);
  /// After stop(), or if the server was never built.
  ~FrameCalls();

  /// Once the server is built.
  void start();
  /// Ends calls that have not opened a stream; the host tells the others.
  void announce_stop();
  /// Number of open calls.
  size_t open() const;
  /// Bytes of answers that clients have not taken.
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
