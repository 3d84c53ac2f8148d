#pragma once
// What options must fulfil together.

#include <string>
#include <vector>

#include "server/config/config.hpp"

namespace collided::server {

/// Throws ConfigError if options contradict each other, or would put plain text on a network unasked.
void check_rules(const Config& config);

/// What is allowed, but should be known: who can reach the daemon without TLS or without showing who he is.
std::vector<std::string> exposure_warnings(const Config& config);

}  // namespace collided::server
