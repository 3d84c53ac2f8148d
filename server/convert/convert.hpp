#pragma once
// Between the protocol and the engine. Every message that names a field names its path, value and limit.

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/config/config.hpp"
#include "server/scenes/frame_run.hpp"
#include "server/scenes/scene.hpp"
#include "server/scenes/scene_store.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Of a scene. With the longest names one still fits one message of gRPC's default size.
constexpr int kMaxMeshes = 16384;

/// What the parsing of a scene needs to know of the daemon.
struct SceneDefaults {
  std::string backend = "auto";
  int threads = 0;
  Limits limits;              ///< with those of the client that asks
  bool cuda = false;          ///< whether a CUDA device can be used
  bool local_socket = false;  ///< whether frames may come by shared memory, past the limit of a message
};

/// Checks a request for a scene. Throws InvalidInput, Unimplemented, LimitExceeded,
/// FailedPrecondition.
SceneRequest parse_scene(const pb::CreateSceneRequest& request, const SceneDefaults& defaults);

/// Where triangles are, in messages.
struct TrianglePath {
  std::string field;
  uint64_t first = 0;  ///< triangles that came before
};

/// Checks and takes each triangle of a packed uint32[n][3] array. Throws InvalidInput.
void for_each_triangle(std::string_view bytes, uint32_t vertex_count, const TrianglePath& path,
                       const std::function<void(const TriangleCorners&)>& take);

/// Bytes of one update that are not in its message.
struct PlacedPositions {
  std::span<const std::byte> start, end, indices;
};

/// Checks what the frame overrides of its scene, and names where its positions are: in `placed` (one entry for each
/// update, or none at all) or else in `frame` itself; both must outlive the result. Throws InvalidInput, Unimplemented.
PendingFrame parse_frame(const pb::Frame& frame, std::span<const PlacedPositions> placed, const SceneSpec& scene);

void fill_scene(const Scene& scene, pb::Scene* out);
void fill_device(const DeviceInfo& device, pb::Device* out);
/// The daemon's limits, and those of the client that asks.
void fill_limits(const Limits& limits, const ClientLimits& client, pb::ServerLimits* out);

void fill_done(const FrameResult& result, const FrameCost& cost, pb::FrameDone* out);

}  // namespace collided::server
