#pragma once
// Addresses of daemons, as gRPC takes them.

#include <string>

namespace collided::client {

/// Whether a gRPC address is on this host for certain: unix:..., localhost or a loopback IP.
bool is_local_address(const std::string& address);

/// Throws Error (INVALID_ARGUMENT, field "address") for a host without a port, which gRPC would take to be 443, and for
/// a port that is not from 1 to 65535, which it would wrap around. Addresses with a scheme, such as dns:///host, need
/// no port; those that have none, such as unix:/path, are not looked into.
void check_address(const std::string& address);

}  // namespace collided::client
