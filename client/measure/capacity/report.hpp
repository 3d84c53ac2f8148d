#pragma once
// What a workload needs, as JSON and in sentences.

#include <optional>
#include <string>

#include "client/app/report/json.hpp"
#include "client/measure/capacity/plan.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::cli {

/// All that the answer is made from.
struct Capacity {
  Workload workload;
  v1::EstimateSceneResponse estimate;
  std::optional<Measured> measured;
  SceneCost scene;
  uint64_t usable_bytes = 0;  ///< of a device
  Plan plan;
  v1::ServerLimits limits;
};

/// Adds the workload's keys to those of the scene.
void add_capacity(Json& out, const Capacity& capacity);

/// How many devices are needed and why, in one line.
std::string verdict(const Capacity& capacity);
/// What the figures take for granted or leave out, a sentence each.
std::vector<std::string> assumptions(const Capacity& capacity);
/// Limits of the daemon below the scenes that a device is to have, a sentence each.
std::vector<std::string> limit_warnings(const Capacity& capacity);

}  // namespace collided::cli
