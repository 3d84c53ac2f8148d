// Cuts a frame's contacts, and its shortened ways, into chunks that fit a message.
#include "server/convert/chunks.hpp"

#include <algorithm>

namespace collided::server {
namespace {

// Field numbers of SharedArrays are those of ContactChunk, which has kind and count first.
constexpr int kFieldShift = 2;
static_assert(int{pb::ContactChunk::kElementsFieldNumber} == pb::SharedArrays::kElementsFieldNumber + kFieldShift);
static_assert(int{pb::ContactChunk::kFlagsFieldNumber} == pb::SharedArrays::kFlagsFieldNumber + kFieldShift);
static_assert(int{pb::ContactChunk::kWorldsFieldNumber} == pb::SharedArrays::kWorldsFieldNumber + kFieldShift);
static_assert(int{pb::ContactChunk::kFeaturesFieldNumber} == pb::SharedArrays::kFeaturesFieldNumber + kFieldShift);
static_assert(int{pb::ContactChunk::kSignedDistancesFieldNumber} ==
              pb::SharedArrays::kSignedDistancesFieldNumber + kFieldShift);

// The engine's bytes go out as they are.
static_assert(kFlagCertified == int{pb::CONTACT_FLAG_CERTIFIED} && kFlagNear == int{pb::CONTACT_FLAG_NEAR} &&
              kFlagCapped == int{pb::CONTACT_FLAG_CAPPED} && kFlagInitial == int{pb::CONTACT_FLAG_INITIAL} &&
              kFlagSeparating == int{pb::CONTACT_FLAG_SEPARATING} && kFlagCovered == int{pb::CONTACT_FLAG_COVERED} &&
              kFlagTouching == int{pb::CONTACT_FLAG_TOUCHING});

// The number in ContactChunk of each field's array.
template <class T>
using FieldNumber = int;
constexpr PerField<FieldNumber> kFieldNumbers{
    pb::ContactChunk::kElementsFieldNumber, pb::ContactChunk::kToiFieldNumber,
    pb::ContactChunk::kDistanceFieldNumber, pb::ContactChunk::kWeightsFieldNumber,
    pb::ContactChunk::kNormalsFieldNumber,  pb::ContactChunk::kFlagsFieldNumber,
    pb::ContactChunk::kFeaturesFieldNumber, pb::ContactChunk::kSignedDistancesFieldNumber};

// The wanted fields that exist for this kind at the frame's accuracy.
OutputFields available(OutputFields fields, ContactKind kind, const ContactSet& set) {
  fields.stencils &= stencil_finder(kind) != nullptr;
  for_each_field(
      [&](ContactField field, const auto& column) {
        if (column.empty()) fields.columns = fields.columns.without(field);
      },
      set);
  return fields;
}

}  // namespace

std::vector<PlacedArray> arrays_of(const PlacedContacts& placed) {
  std::vector<PlacedArray> out;
  const auto add = [&](int number, const ArrayRange& range) {
    if (range.bytes > 0) out.push_back({number, range});
  };
  for_each_field([&](ContactField, const ArrayRange& range, int number) { add(number, range); }, placed, kFieldNumbers);
  add(pb::ContactChunk::kStencilsFieldNumber, placed.stencils);
  return out;
}

std::vector<ChunkArray> Chunk::arrays() const {
  std::vector<ChunkArray> out;
  for_each_field(
      [&](ContactField field, const auto& column, int number) {
        if (!fields.columns.has(field)) return;
        out.push_back({number, std::as_bytes(std::span(column).subspan(begin, end - begin))});
      },
      *set, kFieldNumbers);
  return out;
}

std::vector<ChunkArray> MadeArrays::arrays() const {
  std::vector<ChunkArray> out;
  if (!stencils.empty()) out.push_back({pb::ContactChunk::kStencilsFieldNumber, std::as_bytes(std::span(stencils))});
  if (!worlds.empty()) out.push_back({pb::ContactChunk::kWorldsFieldNumber, std::as_bytes(std::span(worlds))});
  return out;
}

MadeArrays Chunk::make_arrays(const Topology& topology) const {
  MadeArrays made;
  if (fields.stencils) {
    made.stencils.reserve(count());
    const FindVertices stencil = stencil_finder(kind);
    for (size_t i = begin; i < end; ++i) made.stencils.push_back(stencil(set->elements[i], topology));
  }
  if (fields.worlds) {
    made.worlds.resize(count());
    auto world = std::upper_bound(begins->begin(), begins->end(), begin) - begins->begin() - 1;
    for (size_t i = begin; i < end; ++world)
      for (const size_t last = std::min<size_t>(end, (*begins)[static_cast<size_t>(world) + 1]); i < last; ++i)
        made.worlds[i - begin] = static_cast<uint32_t>(world);
  }
  return made;
}

size_t fit_at_end(std::span<const size_t> sizes, size_t max_bytes) {
  size_t count = 0;
  for (size_t bytes = 0; count < sizes.size(); ++count) {
    bytes += sizes[sizes.size() - 1 - count];
    if (bytes > max_bytes) break;
  }
  return count;
}

std::vector<Chunk> cut_into_chunks(const PerKind<ContactSet>& contacts, const OutputFields& fields, size_t max_bytes,
                                   const PerKind<std::vector<uint64_t>>* begins) {
  std::vector<Chunk> chunks;
  const auto cut = [&](ContactKind kind, const ContactSet& set) {
    const OutputFields present = available(fields, kind, set);
    const size_t step = std::max<size_t>(1, max_bytes / std::max<size_t>(1, present.contact_bytes()));
    for (size_t begin = 0; begin < set.size(); begin += step)
      chunks.push_back({kind, &set, begin, std::min(begin + step, set.size()), present,
                        present.worlds ? &value_of(*begins, kind) : nullptr});
  };
  for_each_kind(cut, contacts);
  return chunks;
}

std::array<ChunkArray, 2> WaysChunk::arrays() const {
  return {{{pb::ShortenedWays::kIdsFieldNumber, std::as_bytes(ids)},
           {pb::ShortenedWays::kFractionsFieldNumber, std::as_bytes(fractions)}}};
}

std::vector<WaysChunk> cut_into_chunks(const ShortenedWays& ways, size_t max_bytes) {
  std::vector<WaysChunk> chunks;
  const std::span<const uint32_t> ids = ways.ids;
  const std::span<const double> fractions = ways.fractions;
  const size_t step = std::max<size_t>(1, max_bytes / (sizeof(ids[0]) + sizeof(fractions[0])));
  for (size_t begin = 0; begin < ids.size(); begin += step) {
    const size_t count = std::min(step, ids.size() - begin);
    chunks.push_back({ids.subspan(begin, count), fractions.subspan(begin, count)});
  }
  return chunks;
}

void fill_ways(const WaysChunk& chunk, pb::ShortenedWays* out) {
  out->set_ids(chunk.ids.data(), chunk.ids.size_bytes());
  out->set_fractions(chunk.fractions.data(), chunk.fractions.size_bytes());
}

void fill_chunk(const Chunk& chunk, const Topology& topology, pb::ContactChunk* out) {
  out->set_kind(to_message(chunk.kind));
  out->set_count(chunk.count());
  const auto put = [&](const ChunkArray& array) {
    out->GetReflection()->SetString(out, pb::ContactChunk::descriptor()->FindFieldByNumber(array.field),
                                    std::string(reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size()));
  };
  for (const ChunkArray& array : chunk.arrays()) put(array);
  const MadeArrays made = chunk.make_arrays(topology);
  for (const ChunkArray& array : made.arrays()) put(array);
}

pb::SharedRange* range_of(pb::SharedArrays* shared, int field) {
  const auto* range = pb::SharedArrays::descriptor()->FindFieldByNumber(field - kFieldShift);
  return static_cast<pb::SharedRange*>(shared->GetReflection()->MutableMessage(shared, range));
}

void share_chunk(const Chunk& chunk, const MadeArrays& made, pb::ContactChunk* out,
                 const std::function<void(std::span<const std::byte> bytes, pb::SharedRange* range)>& put) {
  out->set_kind(to_message(chunk.kind));
  out->set_count(chunk.count());
  pb::SharedArrays* const shared = out->mutable_shared();
  for (const ChunkArray& array : chunk.arrays()) put(array.bytes, range_of(shared, array.field));
  for (const ChunkArray& array : made.arrays()) put(array.bytes, range_of(shared, array.field));
}

}  // namespace collided::server
