#pragma once
// Names the groups that share a device's time. No gRPC here.

#include <string>
#include <vector>

namespace collided::server {

/// Names a client by its groups, the outermost first. Each group has an equal share of its parent's time.
using TurnPath = std::vector<std::string>;

}  // namespace collided::server
