#pragma once
// What a frame of a set does with each world: it has positions of it or not, and they count or are refused.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "gpu/base/worlds.hpp"
#include "gpu/exec/asks.hpp"
#include "gpu/positions/checks.hpp"

namespace collided {

class WorldFrames {
 public:
  /// Of a frame with these meshes. Refuses worlds whose turn for them it is not (check_turn).
  WorldFrames(const SceneSpec& spec, const std::vector<SentMesh>& meshes, const FirstMeshes& first, Asks& asks);

  /// Of each world: kStepsWorld, kIsFirstOfWorld.
  const std::vector<uint8_t>& frame() const { return frame_; }
  bool steps(uint32_t world) const { return (frame_[world] & kStepsWorld) != 0; }
  uint64_t count() const {
    return static_cast<uint64_t>(std::count_if(frame_.begin(), frame_.end(), [](uint8_t f) { return f != 0; }));
  }
  /// Ascending.
  std::vector<RefusedWorld> refused() &&;

  /// Refuses the world with what check() throws, if it throws InvalidInput.
  template <class Check>
  void unless_refused(uint32_t world, const Check& check) {
    try {
      check();
    } catch (const InvalidInput& e) {
      frame_[world] = 0;
      refused_.push_back({world, e.field(), e.what()});
    }
  }

 private:
  std::vector<uint8_t> frame_;
  std::vector<RefusedWorld> refused_;
};

}  // namespace collided
