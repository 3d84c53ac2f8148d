#pragma once
// A checked request for a scene, in the engine's terms. No gRPC here.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/scenes/device_bytes.hpp"

namespace collided::server {

/// Contact fields that the scene's clients want.
struct OutputFields {
  bool elements = false, stencils = false, toi = false, distance = false, weights = false, flags = false;
  /// Bytes of one contact's arrays.
  size_t contact_bytes() const {
    return elements * 8u + stencil_bytes() + toi * 8u + distance * 8u + weights * 16u + flags * 1u;
  }
  /// Those that the engine does not make.
  size_t stencil_bytes() const { return stencils * 16u; }
};

struct MeshPlan {
  std::string name;
  uint64_t triangles = 0;  ///< of the whole mesh
  uint64_t awaited = 0;    ///< those of them that an upload will bring
};

/// A checked request for a scene.
struct ScenePlan {
  std::string display_name;
  OutputFields fields;
  std::vector<MeshPlan> meshes;
  SceneSpec engine;
  uint64_t min_bytes = 0;                ///< that the scene holds at the least once it has had a frame
  std::shared_ptr<DeviceBytes> quota{};  ///< of its client, beside the scene's own budget; may be null
};

}  // namespace collided::server
