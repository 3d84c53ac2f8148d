#pragma once
// What a watcher asks for, checked.

#include <chrono>
#include <cstdint>
#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/ops/clock.hpp"
#include "server/scenes/scene/plan.hpp"

namespace collided::server {

namespace pb = collided::v1;

constexpr uint32_t kMaxWatchedContacts = 8192;                    ///< of each kind, in one message
constexpr uint64_t kMaxWatchedPositionBytes = uint64_t{2} << 20;  ///< in one message

/// Which positions a message has.
struct VertexSamples {
  uint32_t stride = 0;                     ///< 0 where there are none
  std::vector<VertexSample> of_mesh = {};  ///< one for each mesh that is watched
};

struct WatchOptions {
  uint32_t frame_interval = 1;
  Clock::duration period{0};          ///< at least this long from one message to the next
  uint32_t max_contacts = 0;          ///< of each kind
  std::vector<uint32_t> meshes = {};  ///< whose positions it sees
  VertexSamples samples = {};         ///< of these
};

/// Throws InvalidInput, naming the field, its value and the limit.
WatchOptions parse_watch(const pb::WatchSceneRequest& request, const ScenePlan& plan);

/// The samples for a scene that was edited since: of the same meshes, with a larger stride if they would not fit.
VertexSamples samples_after_edit(const WatchOptions& options, const ScenePlan& plan);

/// Maximum bytes of one message of such a watch, with these samples.
uint64_t max_watch_message_bytes(const WatchOptions& options, const VertexSamples& samples, const ScenePlan& plan);

}  // namespace collided::server
