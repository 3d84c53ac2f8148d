// A client of the daemon that the options name, or of one started for this command.

#include "client/app/daemon/connection.hpp"

#include <pwd.h>

#include <charconv>
#include <filesystem>
#include <fstream>

#include "client/app/options/usage_error.hpp"

namespace collided::cli {

namespace {

std::string read_token(const std::string& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw std::runtime_error("--token-file " + file + ": is a folder");
  std::ifstream in(file);
  if (!in) throw std::runtime_error("--token-file " + file + ": cannot be read");
  std::string token, more;
  if (!(in >> token) || in >> more)
    throw std::runtime_error("--token-file " + file + ": holds no token, or more than one");
  return token;
}

uid_t user_of(const std::string& word) {
  uid_t id = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
  if (error == std::errc{} && end == word.data() + word.size()) return id;
  const passwd* known = getpwnam(word.c_str());
  if (known == nullptr) throw UsageError("--daemon-user " + word + ": no such user on this host");
  return known->pw_uid;
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

client::LocalOptions local_options(const ServerOptions& options) {
  client::LocalOptions out;
  if (!options.daemon_user.empty()) out.daemon_user = user_of(options.daemon_user);
  return out;
}

client::Client Connection::open(const ServerOptions& options) {
  if (!options.server.empty()) return client::Client::connect(options.server, connect_options(options));
  daemon_.emplace(DaemonOptions{.backend = options.backend, .threads = options.threads});
  return client::Client::connect(daemon_->address());
}

}  // namespace collided::cli
