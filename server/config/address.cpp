// Whether an address is valid, and who can reach it.
#include "server/config/address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <charconv>

namespace collided::server {
namespace {

constexpr size_t kMaxUnixPath = 107;  // sockaddr_un::sun_path without the final 0

// The host without IPv6 brackets.
std::string host_of(const std::string& address) {
  const auto host = address.substr(0, address.rfind(':'));
  return host.starts_with('[') && host.ends_with(']') ? host.substr(1, host.size() - 2) : host;
}

bool is_numeric(const std::string& host) {
  in6_addr any{};
  return inet_pton(AF_INET, host.c_str(), &any) == 1 || inet_pton(AF_INET6, host.c_str(), &any) == 1;
}

bool is_loopback(const std::string& host) {
  in_addr v4{};
  in6_addr v6{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1)
    return IN6_IS_ADDR_LOOPBACK(&v6) || (IN6_IS_ADDR_V4MAPPED(&v6) && v6.s6_addr[12] == 127);
  return host == "localhost";
}

std::string check_host_port(const std::string& address) {
  const auto colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0) return "\"" + address + "\" is neither host:port nor unix:/path";
  unsigned port = 0;
  const char* end = address.data() + address.size();
  const auto [parsed, error] = std::from_chars(address.data() + colon + 1, end, port);
  if (error != std::errc() || parsed != end || port > 65535)
    return "\"" + address + "\": the port must be a number from 0 to 65535";
  return {};
}

}  // namespace

std::string check_socket_path(const std::string& path) {
  if (!path.starts_with('/')) return "\"" + path + "\": a Unix socket needs an absolute path";
  if (path.size() > kMaxUnixPath)
    return "\"" + path + "\": the path has " + std::to_string(path.size()) + " bytes, more than " +
           std::to_string(kMaxUnixPath);
  return {};
}

std::string check_address(const std::string& address) {
  return address.starts_with("unix:") ? check_socket_path(address.substr(5)) : check_host_port(address);
}

std::string check_http_address(const std::string& address) {
  if (!is_numeric(host_of(address))) return "\"" + address + "\" is not a numeric host:port, such as 127.0.0.1:9464";
  return check_host_port(address);
}

bool is_public(const std::string& address) { return !address.starts_with("unix:") && !is_loopback(host_of(address)); }

}  // namespace collided::server
