#pragma once
// How many file descriptors the process may have.

#include <cstddef>

namespace collided::server {

struct DescriptorLimit {
  size_t before = 0;  ///< as the process was started
  size_t now = 0;
};

/// Raises the soft limit of file descriptors to the hard one. Where the system refuses, it stays.
DescriptorLimit raise_descriptor_limit();

/// The soft limit.
size_t descriptor_limit();

/// The most connections of gRPC that such a limit leaves room for: half of it, at most 1,024 unless `wanted` (0: as
/// many as that) asks for more, and never more than all but a quarter of it.
size_t connections_for(size_t descriptors, size_t wanted);

}  // namespace collided::server
