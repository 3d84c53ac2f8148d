#pragma once
// Who calls, and what it may have.

#include <memory>
#include <string>

#include "server/config/config.hpp"

namespace collided::server {

struct ClientIdentity {
  std::string name;  ///< of its token or certificate; "anonymous" where the daemon asks for neither
  ClientLimits limits;
};

using Client = std::shared_ptr<const ClientIdentity>;

}  // namespace collided::server
