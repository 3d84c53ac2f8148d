// Fetches a page over plain HTTP.

#include "client/measure/load/daemon/http_get.hpp"

#include <httplib.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "client/app/options/usage_error.hpp"

namespace collided::cli::load {

namespace {

constexpr time_t kTimeoutSeconds = 5;

[[noreturn]] void fail(const HttpUrl& url, const std::string& why) {
  throw std::runtime_error("no metrics from http://" + url.host + ":" + std::to_string(url.port) + url.path + ": " +
                           why);
}

/// 0 for what is no port.
int port_of(std::string_view text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc{} && end == text.data() + text.size() && port <= 65535 ? port : 0;
}

}  // namespace

HttpUrl parse_url(const std::string& option, const std::string& text) {
  constexpr std::string_view kScheme = "http://";
  const std::string rest = text.starts_with(kScheme) ? text.substr(kScheme.size()) : text;
  const size_t slash = std::min(rest.find('/'), rest.size()), colon = rest.rfind(':', slash);
  const int port = colon == std::string::npos ? 0 : port_of(rest.substr(colon + 1, slash - colon - 1));
  if (port <= 0 || colon == 0 || rest.find("://") != std::string::npos)
    throw UsageError(option + ": '" + text + "' is not an address such as http://127.0.0.1:9464/metrics");
  HttpUrl url{rest.substr(0, colon), port, slash == rest.size() ? "/metrics" : rest.substr(slash)};
  if (url.host.starts_with('[') && url.host.ends_with(']')) url.host = url.host.substr(1, url.host.size() - 2);
  return url;
}

std::string http_get(const HttpUrl& url) {
  httplib::Client client(url.host, url.port);
  client.set_connection_timeout(kTimeoutSeconds);
  client.set_read_timeout(kTimeoutSeconds);
  client.set_write_timeout(kTimeoutSeconds);
  const httplib::Result answer = client.Get(url.path.c_str());
  if (!answer) fail(url, httplib::to_string(answer.error()));
  if (answer->status != 200) fail(url, std::to_string(answer->status) + " " + answer->reason);
  return answer->body;
}

}  // namespace collided::cli::load
