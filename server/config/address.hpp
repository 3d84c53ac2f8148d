#pragma once
// Whether an address is valid, and who can reach it.

#include <string>

namespace collided::server {

/// Empty if the address is host:port or unix:/path, else what is wrong with it.
std::string check_address(const std::string& address);
/// Empty if the address is host:port with a numeric host, else what is wrong with it.
std::string check_http_address(const std::string& address);
/// Empty if the path is absolute and fits into a Unix socket's address, else what is wrong with it.
std::string check_socket_path(const std::string& path);

/// Whether other hosts can reach a valid address, that is, whether it is neither a Unix socket nor a loopback address.
/// Names other than "localhost" count as reachable.
bool is_public(const std::string& address);

}  // namespace collided::server
