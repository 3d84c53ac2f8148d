#pragma once
// Finds the client of a call by its credentials.

#include <functional>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include "server/auth/client.hpp"
#include "server/config/config.hpp"

namespace collided::server {

struct ClientTable;

/// Thread-safe.
class Authenticator {
 public:
  /// Reads the tokens file. Throws ConfigError with what is wrong with it.
  explicit Authenticator(const Config& config);
  ~Authenticator();

  /// `authorization`: the header as received ("Bearer <token>"); `certificate_name`: of the client's verified
  /// certificate; each empty if there is none. With a tokens file a valid token is required; without one, but with a CA
  /// for clients, a certificate is; without both every caller is "anonymous", and takes turns by its origin. Throws
  /// Unauthenticated, which never contains the token.
  Client identify(std::string_view authorization, std::string_view certificate_name, const Origin& origin = {}) const;

  /// `hook` is called for each admitted call, with gRPC's name of its peer and its client. Must be set before the first
  /// call.
  void watch(std::function<void(std::string_view peer, const ClientIdentity& client)> hook) { hook_ = std::move(hook); }
  void admit(std::string_view peer, const ClientIdentity& client) const {
    if (hook_) hook_(peer, client);
  }

  /// Reads the tokens file again. If that throws ConfigError, nothing changes. Open calls keep their identity.
  void reload(const Config& config);

 private:
  std::shared_ptr<const ClientTable> table() const;

  std::function<void(std::string_view, const ClientIdentity&)> hook_;
  mutable std::mutex mutex_;
  std::shared_ptr<const ClientTable> table_;  // guarded by mutex_
};

}  // namespace collided::server
