// The transports that 'collidectl bench --end-to-end' compares.

#include "client/cli/end_to_end_ways.hpp"

namespace collided::cli {

namespace {

Way way(const std::string& name, const std::string& address, client::Local local, bool in_place = false) {
  const auto open = [address, local](const v1::Scene& scene) {
    return client::Client::connect(address).stream(scene, {.window = 1, .local = {.use = local}});
  };
  return {.name = name, .open = open, .in_place = in_place};
}

}  // namespace

std::vector<Way> ways_of(const OwnDaemon& daemon) {
  return {way("grpc tcp", daemon.tcp_address(), client::Local::kOff),
          way("grpc unix", daemon.address(), client::Local::kOff),
          way("shared, copied", daemon.address(), client::Local::kOn),
          way("shared, in place", daemon.address(), client::Local::kOn, true)};
}

}  // namespace collided::cli
