#pragma once
// Refuses to start where the system's limits leave too few threads or too little memory. gRPC does not check whether
// its threads start: without one it hangs, or reads through a null pointer.

#include <cstddef>
#include <cstdint>

#include "server/config/config.hpp"

namespace collided::server {

/// What the daemon takes until it has served its first client.
struct StartNeeds {
  size_t threads = 0;          ///< besides the main thread
  uint64_t address_space = 0;  ///< bytes, besides what the process has mapped
  uint64_t data = 0;           ///< bytes that it may write to, likewise
};

StartNeeds start_needs(const Config& config, unsigned cores, uint64_t stack_bytes);

/// Compares the needs with RLIMIT_AS and RLIMIT_DATA, and starts as many threads for a moment. Throws
/// std::runtime_error that names need and limit. To be called before any thread exists.
void check_start_limits(const Config& config);

}  // namespace collided::server
