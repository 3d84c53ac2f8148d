#pragma once
// A private daemon (--private) serves the process that started it alone. Its options have other defaults.

#include <string>

#include "server/config/config.hpp"

namespace collided::server {

/// Sets the defaults of a daemon whose only client may use everything.
void set_private_defaults(Config& config);

/// Puts the sockets that no option has named into `folder`. Throws ConfigError if they do not go with other options.
void add_private_sockets(Config& config, const std::string& folder);

}  // namespace collided::server
