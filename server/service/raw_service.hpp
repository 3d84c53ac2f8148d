#pragma once
// How each method of the service is served: StreamFrames raw and by completion queues, the others by callbacks.

#include "collided/v1/collision_service.grpc.pb.h"

namespace collided::server {

namespace pb = collided::v1;

template <class Base>
using WithCallbacks = pb::CollisionService::WithCallbackMethod_GetServerInfo<
    pb::CollisionService::WithCallbackMethod_CreateScene<pb::CollisionService::WithCallbackMethod_UploadMesh<
        pb::CollisionService::WithCallbackMethod_GetScene<pb::CollisionService::WithCallbackMethod_ListScenes<
            pb::CollisionService::WithCallbackMethod_DeleteScene<pb::CollisionService::WithCallbackMethod_DetectFrame<
                pb::CollisionService::WithCallbackMethod_WatchScene<Base>>>>>>>>;

using RawService = pb::CollisionService::WithRawMethod_StreamFrames<WithCallbacks<pb::CollisionService::Service>>;

}  // namespace collided::server
