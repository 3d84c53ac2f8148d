#pragma once
// Scenes from the protocol to the engine. Every refusal names the field's path, its value and the limit.

#include <string>

#include "collided/v1/collision_service.pb.h"
#include "server/config/config.hpp"
#include "server/scenes/scene_store.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// What the parsing of a scene needs to know of the daemon.
struct SceneDefaults {
  std::string backend = "auto";
  int threads = 0;
  Limits limits;              ///< with those of the client that asks
  bool cuda = false;          ///< whether a CUDA device can be used
  bool local_socket = false;  ///< whether frames may come by shared memory, past the limit of a message
};

/// Checks a request for a scene. Throws InvalidInput, Unimplemented, LimitExceeded, FailedPrecondition.
SceneRequest parse_scene(const pb::CreateSceneRequest& request, const SceneDefaults& defaults);

}  // namespace collided::server
