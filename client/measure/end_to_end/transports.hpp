#pragma once
// The transports that 'collidectl bench --end-to-end' compares.

#include <functional>
#include <string>
#include <vector>

#include "client/app/daemon/own_daemon.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

struct Transport {
  std::string name;
  std::function<client::FrameStream(const v1::Scene&)> open;
  bool in_place = false;  ///< positions are written straight to the shared memory
};

/// `daemon` has started all transports.
std::vector<Transport> transports_of(const OwnDaemon& daemon);

}  // namespace collided::cli
