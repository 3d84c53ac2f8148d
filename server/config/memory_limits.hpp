#pragma once
// Limits that nobody set, from the memory that there is and from other limits.

#include <cstdint>
#include <string>

#include "server/config/config.hpp"

namespace collided::server {

/// Bytes. What is not known is 0.
struct Memory {
  uint64_t host = 0;    ///< that the process may use
  uint64_t device = 0;  ///< of the CUDA device that scenes live on; 0: they live on the host alone
};

/// The limits that derive_limits() fills, all 0.
Limits underived_limits();

/// Fills the limits that are 0; the others stay. Of the host's memory half is for scenes (or, if that is less, nine
/// tenths of the device's), at most a quarter for everything on its way in and out, and the rest for all else. One
/// client may have a quarter of what all may, one scene as much as one client. At least 1 MiB, 1 scene and 1 stream.
void derive_limits(Limits& limits, const Memory& memory);

/// One line for people: the memory, and the limits made of it.
std::string describe_limits(const Limits& limits, const Memory& memory);

}  // namespace collided::server
