// A client of the daemon that the options name, or of one started for it.

#include "client/cli/connection.hpp"

#include <fstream>

namespace collided::cli {

namespace {

std::string read_token(const std::string& file) {
  std::ifstream in(file);
  std::string token, more;
  if (!(in >> token) || in >> more)
    throw std::runtime_error("--token-file " + file + ": holds no token, or more than one");
  return token;
}

}  // namespace

client::ConnectOptions connect_options(const ServerOptions& options) {
  client::ConnectOptions out;
  if (!options.token_file.empty()) out.token = read_token(options.token_file);
  out.tls_ca = options.tls_ca;
  out.tls_certificate = options.tls_certificate;
  out.tls_key = options.tls_key;
  return out;
}

client::Client Connection::open(const ServerOptions& options) {
  if (!options.server.empty()) return client::Client::connect(options.server, connect_options(options));
  daemon_.emplace(DaemonOptions{.backend = options.backend, .threads = options.threads});
  return client::Client::connect(daemon_->address());
}

}  // namespace collided::cli
