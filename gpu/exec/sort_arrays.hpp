#pragma once
// What the verbs sort_pairs and sort_keys work on.

#include "gpu/base/host_device.hpp"

namespace collided {

/// Keys with a value each, or without (values is empty), and room for as many again.
struct SortArrays {
  Span<uint64_t> keys, other_keys;
  Span<uint32_t> values, other_values;
};

/// Keys of two 32-bit ids, and what is done with each in ascending order: write(its place, key, its place in `keys`);
/// the last is of no matter unless write.has_data().
template <class Write>
struct KeyArrays {
  Span<const uint64_t> keys;
  Span<uint64_t> scratch, other;  ///< room for as many again, each; other may be `keys`, which are lost then
  Write write;
};

}  // namespace collided
