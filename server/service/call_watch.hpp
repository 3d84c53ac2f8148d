#pragma once
// Counts every call but the frame streams, which count themselves; logs those that are refused; tells of those that
// ended before they brought anything.

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_interceptor.h>

#include <atomic>
#include <functional>
#include <string>
#include <utility>

#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {

/// Called for each call that its client cancelled before it had brought a message.
using Fruitless = std::function<void(const std::string& peer)>;

class CallWatch final : public grpc::experimental::Interceptor {
 public:
  /// The references outlive it.
  CallWatch(grpc::experimental::ServerRpcInfo& call, std::string_view method, Metrics& metrics,
            const Fruitless& fruitless)
      : call_(call), method_(method), metrics_(metrics), fruitless_(fruitless) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override;

 private:
  void ended(const grpc::Status& status) const;

  grpc::experimental::ServerRpcInfo& call_;
  const std::string method_;
  Metrics& metrics_;
  const Fruitless& fruitless_;
  CallIds ids_;
  std::atomic<bool> has_message_ = false;
};

class CallWatches final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  CallWatches(Metrics& metrics, Fruitless fruitless) : metrics_(metrics), fruitless_(std::move(fruitless)) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override;

 private:
  Metrics& metrics_;
  const Fruitless fruitless_;
};

}  // namespace collided::server
