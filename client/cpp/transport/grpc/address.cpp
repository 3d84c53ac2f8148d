// Addresses of daemons, as gRPC takes them.

#include "client/cpp/transport/grpc/address.hpp"

#include <arpa/inet.h>
#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>

#include "client/cpp/error.hpp"

namespace collided::client {

namespace {

constexpr std::array<std::string_view, 3> kHostSchemes{"dns:", "ipv4:", "ipv6:"};
constexpr std::array<std::string_view, 6> kOtherSchemes{
    "unix:", "unix-abstract:", "vsock:", "xds:", "google-c2p:", "passthrough:"};

template <size_t N>
std::optional<std::string_view> scheme_of(std::string_view address, const std::array<std::string_view, N>& schemes) {
  const auto found = std::find_if(schemes.begin(), schemes.end(), [&](auto one) { return address.starts_with(one); });
  return found == schemes.end() ? std::nullopt : std::optional(*found);
}

/// "[::1]:50051" to "::1", "localhost:50051" to "localhost".
std::string host_of(std::string address) {
  if (const auto scheme = scheme_of(address, kHostSchemes)) {
    address.erase(0, scheme->size());
    address.erase(0, address.find_first_not_of('/'));
  }
  if (const size_t end = address.find(']'); address.starts_with('[') && end != std::string::npos)
    return address.substr(1, end - 1);
  if (std::count(address.begin(), address.end(), ':') > 1) return address;  // a bare IPv6 address
  return address.substr(0, address.find(':'));
}

/// What follows the colon after the host; nothing if there is none. "::1" is a host alone.
std::optional<std::string_view> port_of(std::string_view host_and_port) {
  const bool is_bracketed = host_and_port.starts_with('[');
  const size_t host_end = is_bracketed ? host_and_port.find(']') : 0;
  if (host_end == std::string_view::npos) return {};
  const size_t colon = host_and_port.find(':', host_end);
  const bool is_bare_ipv6 = !is_bracketed && std::count(host_and_port.begin(), host_and_port.end(), ':') > 1;
  if (colon == std::string_view::npos || is_bare_ipv6) return {};
  return host_and_port.substr(colon + 1);
}

bool is_port(std::string_view word) {
  uint16_t port = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), port);
  return error == std::errc() && end == word.data() + word.size() && port > 0;
}

[[noreturn]] void refuse(const std::string& address, const std::string& why) {
  throw Error(grpc::INVALID_ARGUMENT, "address is '" + address + "', " + why, "address");
}

void check_port(const std::string& address, std::string_view host_and_port, bool needs_port) {
  const auto port = port_of(host_and_port);
  if (!port && needs_port) refuse(address, "which has no port; it needs one from 1 to 65535, as in localhost:50551");
  if (port && !is_port(*port))
    refuse(address, "whose port is '" + std::string(*port) + "'; it must be a number from 1 to 65535");
}

}  // namespace

bool is_local_address(const std::string& address) {
  if (address.starts_with("unix:") || address.starts_with("unix-abstract:")) return true;
  if (address.find(',') != std::string::npos) return false;  // a list, whose others may be elsewhere
  const std::string host = host_of(address);
  in_addr ipv4;
  in6_addr ipv6;
  if (inet_pton(AF_INET, host.c_str(), &ipv4) == 1) return ntohl(ipv4.s_addr) >> 24 == 127;
  if (inet_pton(AF_INET6, host.c_str(), &ipv6) == 1) return IN6_IS_ADDR_LOOPBACK(&ipv6);
  return host == "localhost";
}

void check_address(const std::string& address) {
  if (address.empty()) refuse(address, "which is empty; it is host:port or unix:/path");
  if (scheme_of(address, kOtherSchemes)) return;
  const auto scheme = scheme_of(address, kHostSchemes);
  if (!scheme) return check_port(address, address, true);
  std::string_view rest = std::string_view(address).substr(scheme->size());
  if (rest.starts_with("//")) rest.remove_prefix(std::min(rest.find('/', 2), rest.size()));  // who is asked for names
  rest.remove_prefix(std::min(rest.find_first_not_of('/'), rest.size()));
  for (size_t at = 0; at <= rest.size();) {  // ipv4: and ipv6: take several
    const size_t end = std::min(rest.find(',', at), rest.size());
    check_port(address, rest.substr(at, end - at), false);
    at = end + 1;
  }
}

}  // namespace collided::client
