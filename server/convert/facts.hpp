#pragma once
// Facts about scenes, devices and limits, from the engine to the protocol.

#include "collided/v1/collision_service.pb.h"
#include "server/config/config.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

namespace pb = collided::v1;

void fill_scene(const Scene& scene, pb::Scene* out);
/// What a scene of the plan would cost; all but its device. Throws InvalidInput.
void fill_estimate(const ScenePlan& plan, pb::EstimateSceneResponse* out);
void fill_device(const DeviceState& device, pb::Device* out);
void fill_unusable(const UnusableDevice& device, pb::UnusableDevice* out);
/// The daemon's limits, and those of the calling client.
void fill_limits(const Limits& limits, const ClientLimits& client, pb::ServerLimits* out);

}  // namespace collided::server
