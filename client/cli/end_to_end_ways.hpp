#pragma once
// The transports that 'collidectl bench --end-to-end' compares.

#include <functional>
#include <string>
#include <vector>

#include "client/cli/own_daemon.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

/// One way for frames to the daemon and back.
struct Way {
  std::string name;
  std::function<client::FrameStream(const v1::Scene&)> open;
  bool in_place = false;  ///< the simulator has its positions in the memory that it shares
};

std::vector<Way> ways_of(const OwnDaemon& daemon);

}  // namespace collided::cli
