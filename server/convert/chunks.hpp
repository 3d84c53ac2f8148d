#pragma once
// Cuts a frame's contacts, and its shortened ways, into chunks that fit a message.

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "collided/v1/contact.pb.h"
#include "collided/v1/frame.pb.h"
#include "gpu/detector.hpp"
#include "gpu/stencil.hpp"
#include "server/convert/kinds.hpp"
#include "server/scenes/scene/plan.hpp"

namespace collided::server {

/// What each contact that limits a way has, whatever the scene asks for.
constexpr OutputFields kLimitFields{.columns = kFieldsOfLimits, .stencils = true};

/// One array of a chunk: its field number in ContactChunk or ShortenedWays, and its bytes.
struct ChunkArray {
  int field = 0;
  std::span<const std::byte> bytes;
};
struct PlacedArray {
  int field = 0;
  ArrayRange range;
};
/// Those that there are.
std::vector<PlacedArray> arrays_of(const PlacedContacts& placed);

/// The arrays of a chunk that are stored nowhere; those that were not asked for are empty.
struct MadeArrays {
  std::vector<ContactVertices> stencils;
  std::vector<uint32_t> worlds;

  /// Those that there are, in the order of their fields.
  std::vector<ChunkArray> arrays() const;
};

/// Contacts [begin, end) of one kind. Refers to the result that it was made from.
struct Chunk {
  ContactKind kind = {};
  const ContactSet* set = nullptr;
  size_t begin = 0, end = 0;
  OutputFields fields;                            ///< that were asked for and are there
  const std::vector<uint64_t>* begins = nullptr;  ///< of each world's contacts in `set`, where worlds were asked for

  uint32_t count() const { return static_cast<uint32_t>(end - begin); }
  /// Bytes of all its arrays.
  size_t array_bytes() const { return (end - begin) * fields.contact_bytes(); }
  /// The arrays that are stored, in the order of their fields.
  std::vector<ChunkArray> arrays() const;
  MadeArrays make_arrays(const Topology& topology) const;
};

/// Vertex-triangle first, then edge-edge, then triangle-triangle; the arrays of a chunk have at most `max_bytes`
/// together. Fields that were not computed are left out. `begins`: of each world's contacts, where fields.worlds.
std::vector<Chunk> cut_into_chunks(const PerKind<ContactSet>& contacts, const OutputFields& fields, size_t max_bytes,
                                   const PerKind<std::vector<uint64_t>>* begins = nullptr);

/// A run of a frame's shortened ways. Refers to the result that it was made from.
struct WaysChunk {
  std::span<const uint32_t> ids;
  std::span<const double> fractions;

  /// Returns both, in the order of their fields.
  std::array<ChunkArray, 2> arrays() const;
};

/// Bytes of both arrays.
constexpr size_t array_bytes(const ShortenedWays& ways) {
  return ways.ids.size() * (sizeof(ways.ids[0]) + sizeof(ways.fractions[0]));
}

/// Cuts the ways, in order; the arrays of a chunk have at most `max_bytes` together.
std::vector<WaysChunk> cut_into_chunks(const ShortenedWays& ways, size_t max_bytes);

/// The chunk as a message that contains its arrays.
void fill_ways(const WaysChunk& chunk, pb::ShortenedWays* out);

/// How many of the last pieces, of these sizes, fit into one message of at most `max_bytes`.
size_t fit_at_end(std::span<const size_t> sizes, size_t max_bytes);

/// The chunk as a message that contains its arrays.
void fill_chunk(const Chunk& chunk, const Topology& topology, pb::ContactChunk* out);

/// The chunk as a message that names ranges of memory: each array, those of `made` last, is passed with its range to
/// `put`.
void share_chunk(const Chunk& chunk, const MadeArrays& made, pb::ContactChunk* out,
                 const std::function<void(std::span<const std::byte> bytes, pb::SharedRange* range)>& put);
/// The range of one of ContactChunk's arrays, by its field there.
pb::SharedRange* range_of(pb::SharedArrays* shared, int field);

}  // namespace collided::server
