#pragma once
// How many HTTP/2 streams a client has reset, by the bytes that nobody has read yet.

#include <cstddef>

namespace collided::server {

/// Of a connected socket without TLS, in its first unread 64 KiB, which stay unread. An estimate: the payload of other
/// frames may look the same, though hardly by chance.
size_t count_unread_resets(int socket);

}  // namespace collided::server
