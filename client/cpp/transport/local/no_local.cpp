// A build without the local transport.
#include <grpcpp/support/status_code_enum.h>

#include "client/cpp/error.hpp"
#include "client/cpp/transport/local/open_local.hpp"

namespace collided::client {

bool has_local_transport() noexcept { return false; }

std::unique_ptr<FrameTransport> open_local(const LocalDaemon&, const LocalLayout&, const LocalOptions&) {
  throw Error(grpc::FAILED_PRECONDITION,
              "options.local is on, but this client is built without shared memory (COLLIDED_CLIENT_LOCAL)",
              "options.local");
}

}  // namespace collided::client
