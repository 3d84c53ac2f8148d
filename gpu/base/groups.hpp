#pragma once
// Vertices that go the same fraction of their ways, in frames that advance, are a group. It has the number of its first
// vertex.

#include <cstdint>

namespace collided {

/// In place of the group of a vertex that no step moves.
constexpr uint32_t kStands = ~0u;

}  // namespace collided
