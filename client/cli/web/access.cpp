// Who may read a scene through collidectl view.

#include "client/cli/web/access.hpp"

#include <arpa/inet.h>
#include <sys/random.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <stdexcept>
#include <system_error>

#include "client/app/options/usage_error.hpp"

namespace collided::cli {

namespace {

bool is_ip_address(const std::string& host) {
  in6_addr address;
  return inet_pton(AF_INET, host.c_str(), &address) == 1 || inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

/// Splits "host:port" and "[ipv6]:port"; no port: empty. Without brackets IPv6 has no port.
struct HostAndPort {
  explicit HostAndPort(std::string_view text) {
    const size_t bracket = text.starts_with('[') ? text.find(']') : std::string_view::npos;
    if (bracket != std::string_view::npos) {
      host = text.substr(1, bracket - 1);
      rest = text.substr(bracket + 1);
    } else {
      const size_t colon = text.find(':');
      const bool is_ipv6 = colon != std::string_view::npos && text.find(':', colon + 1) != std::string_view::npos;
      host = text.substr(0, is_ipv6 ? std::string_view::npos : colon);
      rest = text.substr(host.size());
    }
    const bool is_cut_off = text.starts_with('[') && bracket == std::string_view::npos;
    is_valid = !host.empty() && !is_cut_off && (rest.empty() || rest[0] == ':');
    if (is_valid && !rest.empty()) port = rest.substr(1);
  }
  std::string host, rest, port;
  bool is_valid = false;
};

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

}  // namespace

ListenAddress parse_listen_address(const std::string& text) {
  const HostAndPort parts(text);
  const std::string port = parts.rest.empty() ? "0" : parts.port;
  const bool is_number = !port.empty() && port.size() <= 5 &&
                         std::all_of(port.begin(), port.end(), [](unsigned char c) { return std::isdigit(c); });
  if (!parts.is_valid || !is_number || std::stoi(port) > 65535)
    throw UsageError("--listen " + text + ": must be HOST:PORT, such as 127.0.0.1:8080, with a port from 0 to 65535");
  return {parts.host, port};
}

std::string make_secret() {
  unsigned char bytes[16] = {};
  while (getrandom(bytes, sizeof bytes, 0) != sizeof bytes)
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "getrandom");
  std::string secret;
  char digits[3];
  for (const unsigned byte : bytes) {
    std::snprintf(digits, sizeof digits, "%02x", byte);
    secret += digits;
  }
  return secret;
}

std::string read_secret(const std::string& file) {
  constexpr size_t kShortest = 16, kLongest = 128;
  std::ifstream in(file);
  if (!in) throw std::runtime_error("--secret-file " + file + ": cannot be read");
  std::string secret, more;
  const bool is_one_word = (in >> std::setw(kLongest + 1) >> secret) && !(in >> std::setw(1) >> more);
  const bool is_plain = std::all_of(secret.begin(), secret.end(),
                                    [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; });
  if (!is_one_word || !is_plain || secret.size() < kShortest || secret.size() > kLongest)
    throw std::runtime_error(
        "--secret-file " + file +
        ": must hold one word of 16 to 128 letters, digits, - and _, such as of 'openssl rand -hex 16'");
  return secret;
}

bool is_equal_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char difference = 0;
  for (size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

bool is_own_host(std::string_view host_header, std::string_view listen_host) {
  const HostAndPort parts(host_header);
  const std::string host = lower(parts.host);
  return parts.is_valid && (host == "localhost" || host == lower(listen_host) || is_ip_address(host));
}

bool is_own_origin(std::string_view origin, std::string_view host_header) {
  const std::string host = lower(host_header), from = lower(origin);
  return from == "http://" + host || from == "https://" + host;  // https: behind a proxy
}

}  // namespace collided::cli
