#pragma once
// Features of a scene, made once from its meshes: scene-wide ids, unique edges, R-triangle ownership.

#include "gpu/tables/fans.hpp"
#include "gpu/tables/rings.hpp"

namespace collided {

struct FeatureTables {
  Topology topology;
  std::vector<std::array<uint32_t, 3>> triangle_edges;  ///< edge ids of corners 0-1, 1-2, 2-0
  std::vector<uint8_t> owned;                           ///< see search/elementary.hpp
  RingTables rings;
  FanTables fans;
};

/// Vertices, or elements, of a scene at most: edges, at most three an element, have 31 bits.
constexpr uint64_t kMaxFeatures = 1u << 29;

/// The mesh of each element.
std::vector<uint32_t> meshes_of_elements(const Topology& topology);

/// Makes all tables but the rings and fans, and asks now and then whether to go on. Throws InvalidInput for an index
/// out of range, an element with a vertex twice, and a mesh without vertices or without elements; one without both was
/// cut.
FeatureTables make_features(const std::vector<MeshSpec>& meshes, Asks& asks);

}  // namespace collided
