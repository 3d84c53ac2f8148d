#pragma once
// Where the last answered frame has left a scene, so that one frame can put another scene there.

#include <optional>
#include <vector>

#include "client/cpp/session/owned_frame.hpp"

namespace collided::client {

class SceneMemory {
 public:
  SceneMemory(const v1::SceneSpec& spec, std::span<const MeshInput> meshes);

  /// A frame that the daemon has applied, and its answer; it takes the frame's memory. Throws Error (DATA_LOSS) if the
  /// daemon cannot have applied it.
  void apply(OwnedFrame&& frame, const FrameOutput& answer);
  /// The scene's first frame, which fixes static and rigid meshes and what is at rest; null until it has been applied.
  const OwnedFrame* first() const { return first_ ? &*first_ : nullptr; }
  /// Every mesh that can move, where it is, for a scene that has had the first frame, and other ones unless it
  /// `is_new`: valid until apply().
  std::vector<FrameUpdate> updates(bool is_new) const;
  /// Of the frame that has these updates.
  FrameOptions options() const;

 private:
  struct Mesh {
    const MeshInput* input;
    uint32_t first_vertex;            ///< scene-wide
    Bytes positions;                  ///< of a deformable one
    std::optional<RigidMatrix> pose;  ///< of a rigid one, once a frame had one
  };

  void move_body(Mesh& mesh, const OwnedUpdate& update, const FrameOutput& answer, bool is_first) const;
  void move_vertices(Mesh& mesh, OwnedUpdate& update, const FrameOutput& answer) const;
  /// Moves `way`, the positions at the start of an update, as far to its end as the frame did. `places`: of a sparse
  /// one.
  void go(const Mesh& mesh, const OwnedUpdate& update, const std::vector<size_t>& places, const FrameAdvance& advance,
          Bytes& way) const;
  /// How many bytes a vertex takes.
  size_t stride() const;

  const v1::DetectionMode mode_;
  const v1::PositionFormat format_;
  std::vector<Mesh> meshes_;
  std::optional<OwnedFrame> first_;
};

}  // namespace collided::client
