#pragma once
// Copies of what a session may have to send again.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "client/cpp/client.hpp"

namespace collided::client {

using Bytes = std::vector<std::byte>;

/// A FrameUpdate with its own memory.
struct OwnedUpdate {
  explicit OwnedUpdate(const FrameUpdate& update);
  /// Valid as long as this is.
  FrameUpdate view() const;

  uint32_t mesh;
  Bytes positions, start_positions, indices;
  std::optional<RigidMatrix> transform, start_transform;
};

struct OwnedFrame {
  OwnedFrame(std::span<const FrameUpdate> frame, const FrameOptions& options);
  /// Valid as long as this is.
  std::vector<FrameUpdate> views() const;

  std::vector<OwnedUpdate> updates;
  FrameOptions options;
};

/// What create_scene takes. It is not copied: `meshes` point into it.
class OwnedScene {
 public:
  OwnedScene(const v1::SceneSpec& spec, std::span<const MeshInput> meshes);
  OwnedScene(const OwnedScene&) = delete;
  OwnedScene& operator=(const OwnedScene&) = delete;

  const v1::SceneSpec& spec() const { return spec_; }
  std::span<const MeshInput> meshes() const { return meshes_; }

 private:
  struct Elements {
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<std::array<uint32_t, 2>> edges;
    std::vector<uint32_t> points;
  };

  const v1::SceneSpec spec_;
  std::vector<MeshInput> meshes_;
  std::vector<Elements> elements_;  ///< of each mesh
};

}  // namespace collided::client
