#pragma once
// The identity of a caller, and its limits.

#include <memory>
#include <string>

#include "server/config/config.hpp"

namespace collided::server {

struct ClientIdentity {
  std::string name = "anonymous";  ///< of its token or certificate; scenes and limits are counted by name
  ClientLimits limits;
};

using Client = std::shared_ptr<const ClientIdentity>;

}  // namespace collided::server
