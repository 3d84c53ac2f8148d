#pragma once
// GetMesh: what a mesh is made of, a page at a time.

#include <memory>

#include "server/scenes/scene_host.hpp"
#include "server/transport/grpc/unary_call.hpp"

namespace collided::server {

/// Answers on the scene's worker thread; the call holds `held` until then. Throws NotFound.
void get_mesh(UnaryCall<pb::GetMeshRequest, pb::GetMeshResponse>& call, SceneHost& host,
              const std::shared_ptr<void>& held);

}  // namespace collided::server
