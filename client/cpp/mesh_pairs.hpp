#pragma once
// How pairs of meshes lie to each other.

#include <cstdint>
#include <vector>

#include "client/cpp/contacts.hpp"
#include "collided/v1/contact.pb.h"

namespace collided::client {

/// Two meshes, one of them a solid at least, that are not apart (v1::CONTACT_FIELD_PAIR_STATES).
struct MeshPair {
  static constexpr uint32_t kNoVertex = ~0u;

  uint32_t first = 0, second = 0;  ///< numbers of the meshes in the scene, first < second
  v1::MeshPairState state = v1::MESH_PAIR_STATE_UNSPECIFIED;
  uint32_t first_inside = 0;     ///< vertices of the first mesh that are inside the second
  uint32_t second_inside = 0;    ///< and of the second inside the first
  uint32_t deepest = kNoVertex;  ///< of these vertices, by its id in the whole scene; the least of several
  double depth = 0;              ///< its distance from the other mesh's surface, >= 0, in the unit of the positions
};

/// Appends one message's pairs. Throws Error (DATA_LOSS) if it has none, or the lengths of its arrays do not match.
/// Throws the same for pairs that do not ascend, an unknown state, a depth below 0, and numbers that a scene of this
/// size does not have; a size of 0 says nothing.
void append(std::vector<MeshPair>& pairs, const v1::MeshPairs& message, const SceneSize& size);

}  // namespace collided::client
