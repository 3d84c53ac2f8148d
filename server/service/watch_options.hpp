#pragma once
// What a watcher asks for, checked.

#include <chrono>
#include <cstdint>
#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/ops/clock.hpp"
#include "server/scenes/scene_plan.hpp"

namespace collided::server {

namespace pb = collided::v1;

constexpr uint32_t kMaxWatchedContacts = 8192;                    ///< of each kind, in one message
constexpr uint64_t kMaxWatchedPositionBytes = uint64_t{2} << 20;  ///< in one message

struct WatchOptions {
  uint32_t frame_interval = 1;
  Clock::duration period{0};  ///< at least this long from one message to the next
  uint32_t max_contacts = 0;  ///< of each kind
  uint32_t vertex_stride = 0;
  std::vector<uint32_t> meshes = {};       ///< whose positions it sees
  std::vector<VertexSample> samples = {};  ///< of each of these meshes
};

/// Throws InvalidInput, naming the field, its value and the limit.
WatchOptions parse_watch(const pb::WatchSceneRequest& request, const ScenePlan& plan);

/// Maximum bytes of one message of such a watch.
uint64_t max_watch_message_bytes(const WatchOptions& options, const ScenePlan& plan);

}  // namespace collided::server
