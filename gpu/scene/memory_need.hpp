#pragma once
// What scenes need of memory, known before it is taken.

#include <cstdint>

#include "gpu/scene/topology.hpp"

namespace collided {

/// Bytes of host memory that make_features() takes at most for so many elements, its result included.
uint64_t max_making_bytes(uint64_t elements);

/// Bytes of host memory that the tables hold.
uint64_t bytes_of(const FeatureTables& features);

}  // namespace collided
