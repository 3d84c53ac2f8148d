#pragma once
// Fetches a page over plain HTTP: the daemon's metrics have no other form.

#include <string>

namespace collided::cli::load {

struct HttpUrl {
  std::string host;
  int port = 0;
  std::string path;
};

/// "http://host:port/path"; without a path it is /metrics, without "http://" that is assumed. Throws UsageError that
/// names `option`.
HttpUrl parse_url(const std::string& option, const std::string& text);

/// The page's text. Throws std::runtime_error that names the address; waits at most 5 s.
std::string http_get(const HttpUrl& url);

}  // namespace collided::cli::load
