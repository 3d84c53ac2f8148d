#pragma once
// Which options go together.

#include <string>
#include <vector>

#include "server/config/config.hpp"

namespace collided::server {

/// Throws ConfigError if options contradict each other, or expose plain text to a network without --allow-insecure.
void check_rules(const Config& config);

/// Warnings about allowed exposure: addresses that other hosts can reach without TLS or without authentication.
std::vector<std::string> exposure_warnings(const Config& config);

}  // namespace collided::server
