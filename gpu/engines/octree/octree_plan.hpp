#pragma once
// What is decided for the octree's stages before a step starts, and how the engines that share these stages differ.

#include <cstdint>

#include "gpu/engines/octree/bottom_up.hpp"
#include "gpu/engines/octree/leaf_pairs.hpp"
#include "gpu/engines/octree/tree.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Engines on the octree's stages whose cells are as large as the triangles, not fractions of the scene.
constexpr bool has_cells_of_triangles(Engine engine) {
  return engine == Engine::kUniformGrid || engine == Engine::kTwoLevelGrid || engine == Engine::kVss;
}
/// Those of them that have one level of cells.
inline bool has_one_level(Engine engine) { return has_cells_of_triangles(engine) && engine != Engine::kTwoLevelGrid; }

/// True if the engine's stages are the octree's.
constexpr bool is_on_octree(Engine engine) {
  return engine == Engine::kOctree || engine == Engine::kTopDown || engine == Engine::kBottomUp ||
         has_cells_of_triangles(engine);
}

inline CutRule cut_rule_of(Engine engine) {
  if (engine == Engine::kTopDown) return CutRule::kTopDown;
  if (engine == Engine::kBottomUp) return CutRule::kBottomUp;
  return has_one_level(engine) ? CutRule::kGrid : CutRule::kTwoStage;
}

struct OctreePlan {
  Engine engine = Engine::kOctree;
  CutCost cost;
  int rounds = 0;         ///< of refinement below the dense levels
  int levels = 0;         ///< dense levels, at most
  int base = 0;           ///< lowest dense level, at most
  bool has_large = true;  ///< there may be triangles that cover many cells
  /// For each triangle with a box; beyond this the step runs again.
  uint64_t max_crowded_tests = kAnyNumberOfTests;

  bool operator==(const OctreePlan&) const = default;
};

}  // namespace collided
