#pragma once
// What a recorded step depends on besides the buffers.

#include <array>

namespace collided {

/// Steps with equal keys run the same functions on the same arguments.
using StepKey = std::array<double, 11>;

}  // namespace collided
