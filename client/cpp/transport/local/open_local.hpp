#pragma once
// Streams over a daemon's local socket, for builds that have them and for those that do not: they need Linux.

#include <chrono>
#include <memory>
#include <string>

#include "client/cpp/transport/frame_transport.hpp"
#include "client/cpp/transport/local/local_layout.hpp"

namespace collided::client {

/// A daemon on this host.
struct LocalDaemon {
  std::string socket;        ///< path
  std::string grpc_address;  ///< whoever listens there is trusted with the token
  std::string token;
  std::chrono::milliseconds patience;  ///< to connect
  std::chrono::milliseconds deadline;  ///< until a packet is taken
};

/// False in a build without COLLIDED_CLIENT_LOCAL.
bool has_local_transport() noexcept;

/// Connects. Throws Error: FAILED_PRECONDITION in a build without it, UNAVAILABLE if nobody listens there,
/// PERMISSION_DENIED if an untrusted user does.
std::unique_ptr<FrameTransport> open_local(const LocalDaemon& daemon, const LocalLayout& layout,
                                           const LocalOptions& options);

}  // namespace collided::client
