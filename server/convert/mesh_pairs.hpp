#pragma once
// How pairs of meshes lie to each other, from the engine to the protocol.

#include <cstddef>
#include <span>
#include <vector>

#include "collided/v1/contact.pb.h"
#include "gpu/detector.hpp"

namespace collided::server {

namespace pb = collided::v1;

using MeshPairStates = std::span<const MeshPairState>;

/// Bytes of one pair in all arrays: two meshes, a state, two numbers of vertices, a vertex, a depth.
constexpr size_t kPairStateBytes =
    2 * sizeof(uint32_t) + sizeof(uint8_t) + 2 * sizeof(uint32_t) + sizeof(uint32_t) + sizeof(double);

constexpr size_t array_bytes(MeshPairStates pairs) { return pairs.size() * kPairStateBytes; }

/// Cuts the pairs, in order; the arrays of each piece have at most `max_bytes` together.
std::vector<MeshPairStates> cut_into_chunks(MeshPairStates pairs, size_t max_bytes);

/// The pairs as a message.
void fill_pairs(MeshPairStates pairs, pb::MeshPairs* out);

}  // namespace collided::server
