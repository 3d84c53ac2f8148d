#pragma once
// What SIGHUP does to the configuration.

#include <string>
#include <vector>

#include "server/config/config.hpp"
#include "server/config/memory_limits.hpp"

namespace collided::server {

struct Reloaded {
  /// `current` with the changes that need no restart: limits (those that are not set derived from the memory), log, tokens.
  Config config;
  std::vector<std::string> restart;  ///< changed options that take effect only after a restart
};

/// Reads the configuration again. `current` has its limits derived. Tokens can be replaced, and be asked for from now on,
/// but not be given up: a file that was cut off would open the daemon to everyone. Throws ConfigError if it is invalid.
Reloaded reload_config(int argc, const char* const* argv, const Config& current, const Memory& memory);

}  // namespace collided::server
