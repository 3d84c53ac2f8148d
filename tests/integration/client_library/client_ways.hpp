#pragma once
// The ways to an engine that a client of the library has: two to a daemon, and one in its own process.

#include <string>

#include "client/cpp/client.hpp"
#include "client/in_process/local.hpp"
#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {

enum class Way { kGrpc, kSharedMemory, kInProcess };
inline constexpr Way kEveryWay[] = {Way::kGrpc, Way::kSharedMemory, Way::kInProcess};

inline client::Local use_of(Way way) { return way == Way::kGrpc ? client::Local::kOff : client::Local::kOn; }

inline std::string name_of(Way way) {
  return way == Way::kGrpc ? "Grpc" : way == Way::kSharedMemory ? "SharedMemory" : "InProcess";
}

/// Of the daemon at `address`, or of an engine of its own, which computes what the daemon does.
inline client::Client client_by(Way way, const std::string& address) {
  return way == Way::kInProcess ? local() : client::Client::connect(address);
}

}  // namespace collided::test
