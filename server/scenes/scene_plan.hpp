#pragma once
// A checked request for a scene, in the engine's terms. No gRPC here.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::server {

/// Contact fields that the scene's clients want.
struct OutputFields {
  bool elements = false, stencils = false, toi = false, distance = false, weights = false, flags = false;
  /// Bytes of one contact's arrays.
  size_t contact_bytes() const {
    return elements * 8u + stencils * 16u + toi * 8u + distance * 8u + weights * 16u + flags * 1u;
  }
};

struct MeshPlan {
  std::string name;
  uint64_t awaited = 0;  ///< triangles that uploads will bring
};

/// A checked request for a scene.
struct ScenePlan {
  std::string display_name;
  OutputFields fields;
  std::vector<MeshPlan> meshes;
  SceneSpec engine;
};

}  // namespace collided::server
