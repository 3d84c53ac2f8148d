#pragma once
// Who calls, and what it may have.

#include <memory>
#include <string>

#include "server/config/config.hpp"

namespace collided::server {

struct ClientIdentity {
  std::string name = "anonymous";  ///< of its token or its certificate; scenes and limits are counted by it
  ClientLimits limits;
};

using Client = std::shared_ptr<const ClientIdentity>;

}  // namespace collided::server
