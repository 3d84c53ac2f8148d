#pragma once
// Which engine finds the pairs of a frame. A scene that leaves the choice open starts with the octree. The hierarchy
// takes over for some frames where a frame of the octree, after whatever refinement did for it, went clearly wrong:
// - more registrations than the dense levels alone may make, or
// - more pair tests than 512 for each triangle and 32 for each pair found explain, or
// - bricks below the dense levels: a scene of mixed scale, which the hierarchy follows by itself (measured: all of the
//   step takes 0.7 times as long on a GPU, and 0.45 to 0.95 times on CPU cores).
// A box test of the hierarchy is taken to cost ten pair tests by tiles (an estimate); it makes some fifty of them for a
// triangle and three for a pair. Hence the factors. Only counters decide, so that all backends choose alike.

#include "gpu/octree/bottom_up.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Engines on the octree's stages whose cells are as large as the triangles, not fractions of the scene.
inline bool has_cells_of_triangles(Engine engine) {
  return engine == Engine::kUniformGrid || engine == Engine::kTwoLevelGrid;
}

inline CutRule cut_rule_of(Engine engine) {
  if (engine == Engine::kTopDown) return CutRule::kTopDown;
  if (engine == Engine::kBottomUp) return CutRule::kBottomUp;
  return engine == Engine::kUniformGrid ? CutRule::kGrid : CutRule::kTwoStage;
}

class EngineChoice {
 public:
  explicit EngineChoice(Engine wanted) : wanted_(wanted) {}

  Engine engine() const {
    if (wanted_ != Engine::kAuto) return wanted_;
    return frames_to_wait_ > 0 ? Engine::kLbvh : Engine::kOctree;
  }

  /// Looks at a frame that the engine has done in full. `refined`: with bricks.
  void observe(const FrameCounts& counts, uint64_t triangles, bool refined) {
    if (frames_to_wait_ > 0)
      --frames_to_wait_;
    else if (refined || goes_wrong(counts, triangles))
      frames_to_wait_ = kFramesToWait;
  }

 private:
  static constexpr int kFramesToWait = 256;  ///< before the octree is tried again
  static bool goes_wrong(const FrameCounts& counts, uint64_t triangles) {
    return counts.registrations > 24 * triangles || counts.tests > 512 * triangles + 32 * counts.pairs;
  }

  const Engine wanted_;
  int frames_to_wait_ = 0;
};

}  // namespace collided
