#pragma once
// A chunk whose arrays stay where they are: its message names ranges of memory.

#include <cstddef>
#include <functional>
#include <span>

#include "collided/v1/contact.pb.h"
#include "server/convert/chunks.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// The range of one of ContactChunk's arrays, by its field there.
pb::SharedRange* range_of(pb::SharedArrays* shared, int field);

/// Fills `out` with the chunk's facts, and passes each array, `stencils` last where there are some, with its range to
/// `put`.
void share_chunk(const Chunk& chunk, const std::vector<Stencil>& stencils, pb::ContactChunk* out,
                 const std::function<void(std::span<const std::byte> bytes, pb::SharedRange* range)>& put);

}  // namespace collided::server
