#pragma once
// Names the groups that share a device's time. No gRPC here.

#include <string>
#include <vector>

namespace collided::server {

/// A client among all: the names of its groups, the outermost first. Each group has an equal share of its parent's time.
using TurnPath = std::vector<std::string>;

}  // namespace collided::server
