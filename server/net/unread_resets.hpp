#pragma once
// Counts the HTTP/2 streams that a client has reset, in bytes not yet read.

#include <cstddef>

namespace collided::server {

/// Of a connected socket without TLS, in its first unread 64 KiB, which stay unread. An estimate: the payload of other
/// frames may look the same, though not by chance.
size_t count_unread_resets(int socket);

}  // namespace collided::server
