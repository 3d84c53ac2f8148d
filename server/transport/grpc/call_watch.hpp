#pragma once
// Counts every call except frame streams, which count themselves; logs refused calls except watches, which log their
// ends; reports calls that are accepted, and calls that were abandoned before they sent a message.

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_interceptor.h>

#include <atomic>
#include <functional>
#include <string>
#include <utility>

#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {

/// Told of calls; shared by all of them.
struct CallEvents {
  std::function<void(const grpc::ServerContextBase& context)> on_accepted;
  std::function<void(const std::string& peer)> on_abandoned;  ///< its client cancelled it before a message arrived
};

class CallWatch final : public grpc::experimental::Interceptor {
 public:
  /// The references must outlive it.
  CallWatch(grpc::experimental::ServerRpcInfo& call, std::string_view method, Metrics& metrics,
            const CallEvents& events)
      : call_(call), method_(method), metrics_(metrics), events_(events) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override;

 private:
  void gone() const;
  void ended(const grpc::Status& status) const;

  grpc::experimental::ServerRpcInfo& call_;
  const std::string method_;
  Metrics& metrics_;
  const CallEvents& events_;
  CallIds ids_;
  std::atomic<bool> has_message_ = false;
};

class CallWatches final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  CallWatches(Metrics& metrics, CallEvents events) : metrics_(metrics), events_(std::move(events)) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override;

 private:
  Metrics& metrics_;
  const CallEvents events_;
};

}  // namespace collided::server
