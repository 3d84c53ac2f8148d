#pragma once
// What the verb sort_pairs works on.

#include "gpu/exec/host_device.hpp"

namespace collided {

/// Keys with a value each, and room for as many again.
struct SortArrays {
  Span<uint64_t> keys, other_keys;
  Span<uint32_t> values, other_values;
};

}  // namespace collided
