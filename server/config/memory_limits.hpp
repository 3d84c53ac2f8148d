#pragma once
// Limits that nobody has set, derived from the available memory and from other limits.

#include <cstdint>
#include <string>

#include "server/config/config.hpp"

namespace collided::server {

/// Bytes; 0 if not known.
struct Memory {
  uint64_t host = 0;    ///< that the process may use
  uint64_t device = 0;  ///< of the CUDA device that scenes live on; 0: they live on the host alone
};

/// The limits that derive_limits() fills, all 0.
Limits underived_limits();

/// Sets the limits that are 0; the others stay. Half of the host's memory is for scenes (or nine tenths of the
/// device's, if that is less), at most a quarter for messages on their way in and out. One client may have a quarter of
/// what all may, one scene as much as one client. At least 1 MiB, 1 scene and 1 stream.
void derive_limits(Limits& limits, const Memory& memory);

/// One line for people: the memory, and the limits derived from it.
std::string describe_limits(const Limits& limits, const Memory& memory);

}  // namespace collided::server
