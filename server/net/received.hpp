#pragma once
// What the kernel has received on a connection.

#include <cstdint>

namespace collided::server {

/// Bytes so far, over TCP; 0 if it is not known.
uint64_t received_bytes(int socket);

}  // namespace collided::server
