#pragma once
// Who is at the other end of a Unix socket, and whether a token may be sent there: anyone may listen at the path that a
// daemon names.

#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

#include "client/cpp/transport/local/local_region.hpp"

namespace collided::client {

/// A connection to the socket at `path`, of a kind such as SOCK_STREAM. Throws Error: INVALID_ARGUMENT if no socket can
/// have that path, UNAVAILABLE if nobody listens there, or takes the connection within `patience`.
LocalFd connect_to_socket(const std::string& path, int kind, std::chrono::milliseconds patience);

/// Has connecting and sending, which wait for a listener that takes nothing, fail after `time`.
void limit_sending(const LocalFd& socket, std::chrono::milliseconds time);

/// The user who listens at the other end of a connected Unix socket. Throws Error (UNAVAILABLE).
uid_t user_at(const LocalFd& socket);

/// The users that this process trusts: its own user and root, `daemon_user` (an id; -1: none), and whoever listens at
/// `grpc_address` if that is a Unix socket, since that user gets the token anyway.
class TrustedUsers {
 public:
  TrustedUsers(std::string grpc_address, int64_t daemon_user,
               std::chrono::milliseconds patience = std::chrono::seconds(5));
  /// Connects to `grpc_address` only for a user who is not trusted otherwise.
  bool contains(uid_t user);
  /// The ids known so far, for messages.
  std::string text() const;

 private:
  std::string grpc_address_;
  std::chrono::milliseconds patience_;
  std::vector<uid_t> users_;
};

/// Throws Error (PERMISSION_DENIED), naming what is wrong, unless a trusted user listens at `socket`, which is
/// connected to `path`, and no one else can put a socket there: its folder belongs to a trusted user, and is not
/// writable for everyone unless it is sticky.
void check_trusted(const LocalFd& socket, const std::string& path, TrustedUsers trusted);

}  // namespace collided::client
