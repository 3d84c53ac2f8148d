#pragma once
// Counts every call except frame streams, which count themselves; logs refused calls except watches, which log their
// ends; reports calls that were abandoned before they sent a message.

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_interceptor.h>

#include <atomic>
#include <functional>
#include <string>
#include <utility>

#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {

/// Called for each call that its client cancelled before a message arrived.
using OnAbandoned = std::function<void(const std::string& peer)>;

class CallWatch final : public grpc::experimental::Interceptor {
 public:
  /// The references must outlive it.
  CallWatch(grpc::experimental::ServerRpcInfo& call, std::string_view method, Metrics& metrics,
            const OnAbandoned& on_abandoned)
      : call_(call), method_(method), metrics_(metrics), on_abandoned_(on_abandoned) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override;

 private:
  void ended(const grpc::Status& status) const;

  grpc::experimental::ServerRpcInfo& call_;
  const std::string method_;
  Metrics& metrics_;
  const OnAbandoned& on_abandoned_;
  CallIds ids_;
  std::atomic<bool> has_message_ = false;
};

class CallWatches final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  CallWatches(Metrics& metrics, OnAbandoned on_abandoned) : metrics_(metrics), on_abandoned_(std::move(on_abandoned)) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override;

 private:
  Metrics& metrics_;
  const OnAbandoned on_abandoned_;
};

}  // namespace collided::server
