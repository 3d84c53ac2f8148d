#pragma once
// What the verbs sort_pairs and sort_keys work on.

#include "gpu/base/host_device.hpp"

namespace collided {

/// Keys with a value each, and room for as many again.
struct SortArrays {
  Span<uint64_t> keys, other_keys;
  Span<uint32_t> values, other_values;
};

/// Keys of two 32-bit ids, each with an entry of `data` or none at all, and where they go.
template <class Data>
struct KeyArrays {
  Span<const uint64_t> keys;
  Span<const Data> data;
  Span<uint64_t> scratch, sorted_keys;
  Span<Data> sorted;
};

/// A backend with a verb sort_keys.
template <class Exec>
concept SortsKeys = requires {
  Exec::kSortsKeys;
};

}  // namespace collided
