#pragma once
// Contacts as they were found, and what is to become of them in order.

#include "gpu/contacts/kinds.hpp"
#include "gpu/exec/counted.hpp"

namespace collided {

/// A list whose contacts are to be put in order.
template <class Write>
struct Unordered {
  Counted count;
  Span<const uint64_t> keys;
  FeatureRanks ranks;
  KindBegins* kinds;  ///< zeroed; where they begin in order
  Write write;
};

}  // namespace collided
