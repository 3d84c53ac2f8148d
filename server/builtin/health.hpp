#pragma once
// gRPC's health service, by callbacks, for callers without a token, too: a call takes no thread, has to ask in time,
// and those who watch are one of few.

#include <grpcpp/support/status.h>

#include <atomic>
#include <mutex>
#include <set>
#include <string>

#include "grpc/health/v1/health.pb.h"
#include "server/service/rpc_router.hpp"
#include "server/service/unary_call.hpp"

namespace collided::server {

class HealthCall;

/// Thread-safe once it is added.
class Health {
 public:
  /// `calls` outlives it.
  explicit Health(const CallParts& calls) : calls_(calls) {}

  /// Before the server is built; it outlives it. `service`: full name of the one that is told of, besides the whole.
  void add_to(RpcRouter& router, std::string service);
  /// Tells those who watch. At first it is not serving.
  void set_serving(bool is_serving);

 private:
  friend class HealthCall;
  using Status = grpc::health::v1::HealthCheckResponse::ServingStatus;

  /// SERVICE_UNKNOWN for others than the one and the whole ("").
  Status status_of(const std::string& service) const;
  void join(HealthCall& call);
  void leave(HealthCall& call);

  const CallParts& calls_;
  std::string service_;
  std::atomic<bool> is_serving_ = false;
  std::mutex mutex_;
  std::set<HealthCall*> watches_;  // guarded by mutex_, which comes before theirs
};

}  // namespace collided::server
