#pragma once
// How many file descriptors the process may have.

#include <cstddef>

namespace collided::server {

struct DescriptorLimit {
  size_t before = 0;  ///< when the process started
  size_t now = 0;
};

/// Raises the soft limit of file descriptors to the hard one, unless the system refuses.
DescriptorLimit raise_descriptor_limit();

/// The soft limit.
size_t descriptor_limit();

/// Maximum number of gRPC connections for a limit of `descriptors`: `wanted`, but at most three quarters of the limit;
/// if `wanted` is 0, half of the limit, at least 8 and at most 1,024.
size_t connections_for(size_t descriptors, size_t wanted);

}  // namespace collided::server
