#pragma once
// Limits left unset, derived from the available memory and from other limits.

#include <cstdint>
#include <string>

#include "server/config/config.hpp"

namespace collided::server {

/// Bytes; 0 if unknown.
struct Memory {
  uint64_t host = 0;    ///< usable by the process
  uint64_t device = 0;  ///< of the CUDA devices that hold scenes, together; 0: scenes live on the host alone
};

/// The limits that derive_limits() fills, all 0.
Limits underived_limits();

/// Fills the limits that are 0. Scenes get half of the host's memory (or nine tenths of the devices', if that is less),
/// messages in transit at most a quarter. One client gets a quarter of the daemon's limits, one scene as many bytes as
/// one client; never less than 1 MiB, 1 scene and 1 stream.
void derive_limits(Limits& limits, const Memory& memory);

/// Bytes of messages that may be on their way in, of all connections. gRPC reads a whole message before it checks its
/// size, and beyond this it ends calls (RESOURCE_EXHAUSTED), so two of the largest messages fit.
uint64_t network_quota(const Limits& limits);

/// One line: the memory, and the limits derived from it.
std::string describe_limits(const Limits& limits, const Memory& memory);

}  // namespace collided::server
