#pragma once
// One WatchScene call. Its messages are built in turns of its client: the scene's worker only hands them over.

#include <memory>
#include <mutex>
#include <optional>

#include "server/service/timed_jobs.hpp"
#include "server/service/watcher.hpp"
#include "server/transport/grpc/request_call.hpp"

namespace collided::server {

class WatchCall final : public RequestCall, public WatchSink, public std::enable_shared_from_this<WatchCall> {
 public:
  /// `host` and `parts` outlive the call. `jobs`: for what it does later.
  static grpc::ServerGenericBidiReactor* serve(grpc::CallbackServerContext& context, SceneHost& host,
                                               const CallParts& parts, TimedJobs& jobs);

  void finish(const grpc::Status& status) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override { alive_.reset(); }

  void show(WatchedUpdate update) override;
  void reserve(uint64_t message_bytes) override;
  void ended(const std::exception_ptr& why) override { finish(to_status(describe(why))); }

 private:
  WatchCall(grpc::CallbackServerContext& context, SceneHost& host, const CallParts& parts, TimedJobs& jobs)
      : RequestCall(context, parts), host_(host), jobs_(jobs) {}

  google::protobuf::Message& request_message() override { return request_; }
  void answer() override;
  void join(const SceneUse& scene);
  void send_opened();
  void build_and_send();
  void send(const pb::WatchSceneResponse& response);
  void await_next();
  void get_ready();
  void cancel_write();
  void post(Clock::time_point when, void (WatchCall::*step)());
  void log_end(const grpc::Status& status) const;

  // `_locked`: the caller holds mutex_.
  void finish_locked();

  SceneHost& host_;
  TimedJobs& jobs_;
  std::shared_ptr<WatchCall> alive_;  // until gRPC is done with the call
  pb::WatchSceneRequest request_;
  std::shared_ptr<Watcher> watcher_;  // set by the request
  Clock::time_point next_ = {};       // when the next message may be sent; set before each frame is written

  std::mutex mutex_;                     // guards what follows
  std::shared_ptr<void> ticket_;         // counts it among its client's streams
  std::unique_ptr<MemoryHold> held_;     // for its messages
  std::optional<WatchedUpdate> update_;  // to be sent next
  std::optional<grpc::Status> status_;   // of the call, once decided
  bool is_open_ = false, is_writing_ = false, is_finishing_ = false;
};

}  // namespace collided::server
