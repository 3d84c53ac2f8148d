#pragma once
// gRPC's reflection, v1 and v1alpha, by callbacks: a call takes no thread, has to ask in time, and is one of few.

#include <string>
#include <vector>

#include "server/service/rpc_router.hpp"
#include "server/service/unary_call.hpp"

namespace collided::server {

class Reflection {
 public:
  /// `calls` outlives it. `is_open`: callers without a token or certificate are answered, too.
  Reflection(const CallParts& calls, bool is_open) : calls_(calls), is_open_(is_open) {}

  /// Before the server is built; it outlives it. `services`: full names of the others that are served.
  void add_to(RpcRouter& router, std::vector<std::string> services);

 private:
  friend class ReflectionCall;

  const CallParts& calls_;
  const bool is_open_;
  std::vector<std::string> services_;
};

}  // namespace collided::server
