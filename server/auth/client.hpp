#pragma once
// The identity of a caller, and its limits.

#include <memory>
#include <string>

#include "server/auth/turn_path.hpp"
#include "server/config/config.hpp"

namespace collided::server {

struct ClientIdentity {
  std::string name = "anonymous";  ///< of its token or certificate; scenes and limits are counted by name
  ClientLimits limits;
  TurnPath turns = {};  ///< whose turns it takes, if not those of its name

  TurnPath turn_path() const { return turns.empty() ? TurnPath{name} : turns; }
};

/// Tells where a call comes from. Callers without a name take turns by it.
struct Origin {
  std::string party;   ///< the address, or "uid:" and the user of a process on this host
  std::string member;  ///< one of that party: a connection, or "pid:" and the process
};

using Client = std::shared_ptr<const ClientIdentity>;

}  // namespace collided::server
