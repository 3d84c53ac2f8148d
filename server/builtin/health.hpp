#pragma once
// gRPC's health service, by callbacks and without a token: a call takes no thread, its request must arrive in time, and
// the number of watchers is limited.

#include <grpcpp/support/status.h>

#include <atomic>
#include <mutex>
#include <set>
#include <string>

#include "grpc/health/v1/health.pb.h"
#include "server/transport/grpc/request_call.hpp"
#include "server/transport/grpc/rpc_router.hpp"

namespace collided::server {

class HealthCall;

/// Thread-safe once it is added.
class Health {
 public:
  /// `calls` must outlive it.
  explicit Health(const CallParts& calls) : calls_(calls) {}

  /// Before the server is built; this object must outlive it. `service`: full name of the service whose health is
  /// reported, besides the daemon's ("").
  void add_to(RpcRouter& router, std::string service);
  /// Notifies the watchers. Initially not serving.
  void set_serving(bool is_serving);

 private:
  friend class HealthCall;
  using Status = grpc::health::v1::HealthCheckResponse::ServingStatus;

  /// SERVICE_UNKNOWN for any other service.
  Status status_of(const std::string& service) const;
  void join(HealthCall& call);
  void leave(HealthCall& call);

  const CallParts& calls_;
  std::string service_;
  std::atomic<bool> is_serving_ = false;
  std::mutex mutex_;
  std::set<HealthCall*> watches_;  // guarded by mutex_, which is locked before theirs
};

}  // namespace collided::server
