// Packs the states of pairs of meshes.
#include "server/convert/mesh_pairs.hpp"

#include <algorithm>
#include <string>

namespace collided::server {
namespace {

uint8_t to_byte(PairState state) {
  switch (state) {
    case PairState::kTouching:
      return pb::MESH_PAIR_STATE_TOUCHING;
    case PairState::kOverlapping:
      return pb::MESH_PAIR_STATE_OVERLAPPING;
    case PairState::kFirstInside:
      return pb::MESH_PAIR_STATE_FIRST_INSIDE;
    case PairState::kSecondInside:
      return pb::MESH_PAIR_STATE_SECOND_INSIDE;
  }
  return pb::MESH_PAIR_STATE_UNSPECIFIED;
}

template <class T>
void append(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::vector<MeshPairStates> cut_into_chunks(MeshPairStates pairs, size_t max_bytes) {
  std::vector<MeshPairStates> chunks;
  const size_t step = std::max<size_t>(1, max_bytes / kPairStateBytes);
  for (size_t begin = 0; begin < pairs.size(); begin += step)
    chunks.push_back(pairs.subspan(begin, std::min(step, pairs.size() - begin)));
  return chunks;
}

void fill_pairs(MeshPairStates pairs, pb::MeshPairs* out) {
  static_assert(MeshPairState::kNoVertex == 4294967295u, "the protocol says so");
  for (const MeshPairState& pair : pairs) {
    for (const uint32_t mesh : {pair.first, pair.second}) append(*out->mutable_meshes(), mesh);
    append(*out->mutable_states(), to_byte(pair.state));
    for (const uint32_t inside : {pair.first_inside, pair.second_inside}) append(*out->mutable_inside(), inside);
    append(*out->mutable_deepest(), pair.deepest);
    append(*out->mutable_depths(), pair.depth);
  }
}

}  // namespace collided::server
