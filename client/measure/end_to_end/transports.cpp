// The transports that 'collidectl bench --end-to-end' compares.

#include "client/measure/end_to_end/transports.hpp"

namespace collided::cli {

namespace {

Transport transport(const std::string& name, const std::string& address, client::Local local, bool in_place = false) {
  const auto open = [address, local](const v1::Scene& scene) {
    return client::Client::connect(address).stream(scene, {.window = 1, .local = {.use = local}});
  };
  return {.name = name, .open = open, .in_place = in_place};
}

}  // namespace

std::vector<Transport> transports_of(const OwnDaemon& daemon) {
  return {transport("grpc tcp", daemon.tcp_address(), client::Local::kOff),
          transport("grpc unix", daemon.address(), client::Local::kOff),
          transport("shared, copied", daemon.address(), client::Local::kOn),
          transport("shared, in place", daemon.address(), client::Local::kOn, true)};
}

}  // namespace collided::cli
