#pragma once
// How many file descriptors the process may have.

#include <cstddef>

namespace collided::server {

struct DescriptorLimit {
  size_t before = 0;  ///< as the process was started
  size_t now = 0;
};

/// Raises the soft limit of file descriptors to the hard one, unless the system refuses.
DescriptorLimit raise_descriptor_limit();

/// The soft limit.
size_t descriptor_limit();

/// Maximum number of gRPC connections for a limit of `descriptors`: half of it, at most 1,024, unless `wanted` (0: no
/// wish) asks for another number; never more than three quarters of it.
size_t connections_for(size_t descriptors, size_t wanted);

}  // namespace collided::server
