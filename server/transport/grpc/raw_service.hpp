#pragma once
// How each method of the service is served: StreamFrames raw and by completion queues, UploadMesh raw and by callbacks,
// the others by RpcRouter. The caller is known before the first message is read.

#include "collided/v1/collision_service.grpc.pb.h"

namespace collided::server {

namespace pb = collided::v1;

template <class Base>
using WithRoutes = pb::CollisionService::WithGenericMethod_GetServerInfo<
    pb::CollisionService::WithGenericMethod_CreateScene<pb::CollisionService::WithGenericMethod_EstimateScene<
        pb::CollisionService::WithGenericMethod_GetScene<pb::CollisionService::WithGenericMethod_GetMesh<
            pb::CollisionService::WithGenericMethod_ListScenes<pb::CollisionService::WithGenericMethod_DeleteScene<
                pb::CollisionService::WithGenericMethod_DetectFrame<pb::CollisionService::WithGenericMethod_WatchScene<
                    pb::CollisionService::WithGenericMethod_CreateScenes<
                        pb::CollisionService::WithGenericMethod_DetectBatch<Base>>>>>>>>>>>;

using RawService = pb::CollisionService::WithRawMethod_StreamFrames<
    pb::CollisionService::WithRawCallbackMethod_UploadMesh<WithRoutes<pb::CollisionService::Service>>>;

}  // namespace collided::server
