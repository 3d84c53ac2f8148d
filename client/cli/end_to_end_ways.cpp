// The transports that 'collidectl bench --end-to-end' compares.

#include "client/cli/end_to_end_ways.hpp"

namespace collided::cli {

namespace {

Way grpc_way(const std::string& name, const std::string& address) {
  const auto open = [address](const v1::Scene& scene) {
    return client::Client::connect(address).stream(scene, {.window = 1});
  };
  return {.name = name, .open = open, .missing = address.empty() ? "the daemon has no such address" : ""};
}

}  // namespace

std::vector<Way> ways_of(const OwnDaemon& daemon) {
  return {grpc_way("grpc tcp", daemon.tcp_address()), grpc_way("grpc unix", daemon.address())};
}

}  // namespace collided::cli
