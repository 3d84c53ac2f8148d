#pragma once
// Edits of a scene from the protocol to the engine. Every refusal names the field's path, its value and the limit.

#include <memory>
#include <vector>

#include "collided/v1/scene.pb.h"
#include "server/config/config.hpp"
#include "server/scenes/scene/plan.hpp"

namespace collided::server {

namespace pb = collided::v1;

struct ParsedEdit {
  std::shared_ptr<const SceneEdit> engine;
  std::vector<EditedMesh> meshes;
};

/// Bytes of the elements that it brings: what parse_edit() copies.
uint64_t element_bytes(const pb::SceneEdit& edit);

/// `plan`: of the scene before. Throws InvalidInput, LimitExceeded.
ParsedEdit parse_edit(const pb::SceneEdit& edit, const ScenePlan& plan, const Limits& limits);

}  // namespace collided::server
