// A chunk whose arrays stay where they are.
#include "server/frames/shared_arrays.hpp"

#include "server/convert/kinds.hpp"

namespace collided::server {
namespace {

// Field numbers of SharedArrays are those of ContactChunk, which has kind and count first.
constexpr int kFieldShift = 2;
static_assert(int{pb::ContactChunk::kElementsFieldNumber} == pb::SharedArrays::kElementsFieldNumber + kFieldShift);
static_assert(int{pb::ContactChunk::kFlagsFieldNumber} == pb::SharedArrays::kFlagsFieldNumber + kFieldShift);

}  // namespace

pb::SharedRange* range_of(pb::SharedArrays* shared, int field) {
  const auto* range = pb::SharedArrays::descriptor()->FindFieldByNumber(field - kFieldShift);
  return static_cast<pb::SharedRange*>(shared->GetReflection()->MutableMessage(shared, range));
}

void share_chunk(const Chunk& chunk, const std::vector<Stencil>& stencils, pb::ContactChunk* out,
                 const std::function<void(std::span<const std::byte> bytes, pb::SharedRange* range)>& put) {
  out->set_kind(to_message(chunk.kind));
  out->set_count(chunk.count());
  pb::SharedArrays* const shared = out->mutable_shared();
  for (const ChunkArray& array : chunk.arrays()) put(array.bytes, range_of(shared, array.field));
  if (!stencils.empty())
    put(std::as_bytes(std::span(stencils)), range_of(shared, pb::ContactChunk::kStencilsFieldNumber));
}

}  // namespace collided::server
