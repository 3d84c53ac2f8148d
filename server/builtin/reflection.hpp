#pragma once
// gRPC's reflection, v1 and v1alpha, by callbacks: a call takes no thread, its requests must arrive in time, and the
// number of calls is limited.

#include <string>
#include <vector>

#include "server/transport/grpc/request_call.hpp"
#include "server/transport/grpc/rpc_router.hpp"

namespace collided::server {

class Reflection {
 public:
  /// `calls` must outlive this object. `is_open`: callers without a token or certificate are answered, too.
  Reflection(const CallParts& calls, bool is_open) : calls_(calls), is_open_(is_open) {}

  /// Before the server is built; this object must outlive it. `services`: full names of the other services.
  void add_to(RpcRouter& router, std::vector<std::string> services);

 private:
  friend class ReflectionCall;

  const CallParts& calls_;
  const bool is_open_;
  std::vector<std::string> services_;
};

}  // namespace collided::server
