#pragma once
// gRPC's reflection, v1 and v1alpha, by callbacks: a call takes no thread, has to ask in time, and is one of few.

#include <string>
#include <vector>

#include "server/scenes/scene_host.hpp"
#include "server/service/rpc_router.hpp"
#include "server/service/unary_call.hpp"
#include "server/service/waiting_calls.hpp"

namespace collided::server {

class Reflection {
 public:
  /// The references outlive it. `is_open`: callers without a token or certificate are answered, too.
  Reflection(const CallParts& calls, const SceneHost& host, WaitingCalls& waiting, bool is_open)
      : calls_(calls), host_(host), waiting_(waiting), is_open_(is_open) {}

  /// Before the server is built; it outlives it. `services`: full names of the others that are served.
  void add_to(RpcRouter& router, std::vector<std::string> services);

 private:
  friend class ReflectionCall;

  const CallParts& calls_;
  const SceneHost& host_;
  WaitingCalls& waiting_;
  const bool is_open_;
  std::vector<std::string> services_;
};

}  // namespace collided::server
