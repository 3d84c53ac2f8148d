#include "client/cpp/transport/local/open_local.hpp"

#include "client/cpp/transport/local/local_peer.hpp"
#include "client/cpp/transport/local/local_transport.hpp"

namespace collided::client {

bool has_local_transport() noexcept { return true; }

std::unique_ptr<FrameTransport> open_local(const LocalDaemon& daemon, const LocalLayout& layout,
                                           const LocalOptions& options) {
  TrustedUsers trusted(daemon.grpc_address, options.daemon_user, daemon.patience);
  return std::make_unique<LocalTransport>(
      LocalPeer{daemon.socket, std::move(trusted), daemon.patience, daemon.deadline}, layout, daemon.token, options);
}

}  // namespace collided::client
