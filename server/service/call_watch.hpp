#pragma once
// Counts every call but the frame streams, which count themselves, and logs those that are refused.

#include <grpcpp/support/server_interceptor.h>

#include "server/ops/log.hpp"
#include "server/ops/metrics.hpp"

namespace collided::server {

class CallWatch final : public grpc::experimental::Interceptor {
 public:
  CallWatch(std::string_view method, Metrics& metrics) : method_(method), metrics_(metrics) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override;

 private:
  void ended(const grpc::Status& status) const;

  const std::string method_;
  Metrics& metrics_;
  CallIds ids_;
};

class CallWatches final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CallWatches(Metrics& metrics) : metrics_(metrics) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override;

 private:
  Metrics& metrics_;
};

}  // namespace collided::server
