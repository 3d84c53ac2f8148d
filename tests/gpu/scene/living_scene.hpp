#pragma once
// A scene that is torn, grows and shrinks while it moves: what is asked of the engine, and what it should then be.

#include <optional>
#include <random>
#include <vector>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/support/case.hpp"

namespace collided::test {

/// What a scene is after a frame.
struct SceneState {
  Case now;   ///< where the last frame began and ended, rounded to the scene's scalar type
  Case rest;  ///< where each mesh's first frame ended
  SceneSpec spec;
};

/// A frame that owns what its input refers to.
struct OwnedFrame {
  FrameInput input() const;

  std::vector<OwnedUpdate> updates;
  std::optional<SceneEdit> edit;
  SceneState after;
};

class LivingScene {
 public:
  LivingScene(Mode mode, Scalar scalar, uint32_t seed);

  const SceneSpec& spec() const { return state_.spec; }
  const Case& now() const { return state_.now; }
  const Case& rest() const { return state_.rest; }
  uint32_t vertex_count() const;

  OwnedFrame first_frame() const;
  /// Some meshes move, others stand still.
  OwnedFrame next_frame();
  /// The same, with one random change of what the scene is made of.
  OwnedFrame next_edit();
  void applied(const OwnedFrame& frame) { state_ = frame.after; }
  /// An edit that is refused, or whose frame is given up.
  void try_in_vain(Detector& detector);

  size_t meshes_added() const { return added_; }
  size_t meshes_removed() const { return removed_; }
  size_t tears() const { return tears_; }

 private:
  uint32_t random(uint32_t end) { return std::uniform_int_distribution<uint32_t>(0, end - 1)(random_); }
  bool is_there(uint32_t mesh) const { return state_.spec.meshes[mesh].vertex_count > 0; }
  std::vector<uint32_t> meshes() const;
  uint32_t any_mesh();
  void add_sheet(SceneState& state, uint32_t mesh);
  MeshSpec random_rules(MeshSpec mesh);

  void add(OwnedFrame& frame, std::vector<bool>& first);
  void remove(OwnedFrame& frame);
  void tear(OwnedFrame& frame, std::vector<bool>& first);
  void drop_triangle(OwnedFrame& frame);
  void change_rules(OwnedFrame& frame);
  void change_pairs(OwnedFrame& frame);
  void move(OwnedFrame& frame, const std::vector<bool>& first);

  std::mt19937 random_;
  SceneState state_;
  size_t added_ = 0, removed_ = 0, tears_ = 0;
};

}  // namespace collided::test
