#pragma once
// Scenes from the protocol to the engine. Every refusal names the field's path, its value and the limit.

#include <string>

#include "collided/v1/collision_service.pb.h"
#include "server/config/config.hpp"
#include "server/scenes/scene_store.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// The daemon's settings that parsing a scene depends on.
struct SceneDefaults {
  std::string backend = "auto";
  int threads = 0;
  Limits limits;                             ///< including those of the calling client
  bool local_socket = false;                 ///< whether frames can use shared memory, beyond the message limit
  std::vector<Device> devices = {Device{}};  ///< that scenes can live on
};

/// Checks the spec of a scene, or of each world of a set of so many. Throws InvalidInput, LimitExceeded,
/// FailedPrecondition.
ScenePlan parse_spec(const pb::SceneSpec& spec, const SceneDefaults& defaults, uint32_t worlds = 0);
/// Checks a request for a scene, or for a set. Throws the same.
SceneRequest parse_scene(const pb::CreateSceneRequest& request, const SceneDefaults& defaults);
SceneRequest parse_scenes(const pb::CreateScenesRequest& request, const SceneDefaults& defaults);

}  // namespace collided::server
