// Fetches a page over plain HTTP.

#include "client/measure/load/daemon/http_get.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "client/cli/options/usage_error.hpp"

namespace collided::cli::load {

namespace {

constexpr timeval kTimeout{5, 0};

struct Socket {
  int file = -1;
  Socket() = default;
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() {
    if (file >= 0) close(file);
  }
};

[[noreturn]] void fail(const HttpUrl& url, const std::string& why) {
  throw std::runtime_error("no metrics from http://" + url.host + ":" + url.port + url.path + ": " + why);
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses addresses_of(const HttpUrl& url) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(url.host.c_str(), url.port.c_str(), &wanted, &found);
  if (error != 0) fail(url, gai_strerror(error));
  return {found, freeaddrinfo};
}

void connect_to(Socket& socket, const HttpUrl& url) {
  const Addresses addresses = addresses_of(url);
  for (const addrinfo* at = addresses.get(); at != nullptr; at = at->ai_next) {
    if (socket.file >= 0) close(socket.file);
    socket.file = ::socket(at->ai_family, at->ai_socktype | SOCK_CLOEXEC, at->ai_protocol);
    setsockopt(socket.file, SOL_SOCKET, SO_RCVTIMEO, &kTimeout, sizeof kTimeout);
    setsockopt(socket.file, SOL_SOCKET, SO_SNDTIMEO, &kTimeout, sizeof kTimeout);
    if (connect(socket.file, at->ai_addr, at->ai_addrlen) == 0) return;
  }
  fail(url, std::strerror(errno));
}

std::string exchange(const Socket& socket, const HttpUrl& url) {
  const std::string request = "GET " + url.path + " HTTP/1.0\r\nHost: " + url.host + "\r\n\r\n";
  if (send(socket.file, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
    fail(url, std::strerror(errno));
  std::string answer;
  char some[65536];
  for (ssize_t size; (size = recv(socket.file, some, sizeof some, 0)) != 0;) {
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) fail(url, std::strerror(errno));
    answer.append(some, static_cast<size_t>(size));
  }
  return answer;
}

}  // namespace

HttpUrl parse_url(const std::string& option, const std::string& text) {
  constexpr std::string_view kScheme = "http://";
  const std::string rest = text.starts_with(kScheme) ? text.substr(kScheme.size()) : text;
  const size_t slash = rest.find('/'), colon = rest.rfind(':', slash);
  const bool is_whole = colon != std::string::npos && colon > 0 && colon + 1 < std::min(slash, rest.size());
  if (!is_whole || rest.find("://") != std::string::npos)
    throw UsageError(option + ": '" + text + "' is not an address such as http://127.0.0.1:9464/metrics");
  HttpUrl url{rest.substr(0, colon), rest.substr(colon + 1, slash - colon - 1),
              slash == std::string::npos ? "/metrics" : rest.substr(slash)};
  if (url.host.starts_with('[') && url.host.ends_with(']')) url.host = url.host.substr(1, url.host.size() - 2);
  return url;
}

std::string http_get(const HttpUrl& url) {
  Socket socket;
  connect_to(socket, url);
  const std::string answer = exchange(socket, url);
  const size_t body = answer.find("\r\n\r\n"), line_end = answer.find("\r\n");
  if (body == std::string::npos || !answer.starts_with("HTTP/1.")) fail(url, "no answer that is HTTP");
  const std::string status = answer.substr(0, line_end);
  if (status.find(" 200 ") == std::string::npos) fail(url, status);
  return answer.substr(body + 4);
}

}  // namespace collided::cli::load
