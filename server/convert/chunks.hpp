#pragma once
// Contacts of a frame cut into runs that fit a message, and where the arrays of a run are.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "collided/v1/contact.pb.h"
#include "gpu/detector.hpp"
#include "server/scenes/scene_plan.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// One array of a chunk: the number of its field in ContactChunk, and its bytes.
struct ChunkArray {
  int field = 0;
  std::span<const std::byte> bytes;
};

/// Contacts begin..end of one kind. Refers to the result it was made from.
struct Chunk {
  pb::ContactKind kind = pb::CONTACT_KIND_UNSPECIFIED;
  const ContactSet* set = nullptr;
  size_t begin = 0, end = 0;
  OutputFields fields;  ///< those that were asked for and that there are

  uint32_t count() const { return static_cast<uint32_t>(end - begin); }
  /// The arrays in the order of their fields, but for the stencils, which are not stored anywhere.
  std::vector<ChunkArray> arrays() const;
  /// uint32[count][4]; empty if not asked for.
  std::vector<std::array<uint32_t, 4>> stencils(const Topology& topology) const;
};

/// Vertex-triangle first, then edge-edge, then triangle-triangle; the arrays of a chunk hold at most `max_bytes`
/// together. What was not computed is left out.
std::vector<Chunk> cut_into_chunks(const FrameResult& result, const OutputFields& fields, size_t max_bytes);

/// How many of the last pieces, whose sizes these are, go into one message of at most `max_bytes`.
size_t fit_at_end(std::span<const size_t> sizes, size_t max_bytes);

/// The chunk as a message that holds its arrays.
void fill_chunk(const Chunk& chunk, const Topology& topology, pb::ContactChunk* out);

}  // namespace collided::server
