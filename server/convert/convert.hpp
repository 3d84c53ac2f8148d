#pragma once
// Between the protocol and the engine. Every message that names a field names its path, value and limit.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "collided/v1/collision_service.pb.h"
#include "server/config/config.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// What the parsing of a scene needs to know of the daemon.
struct SceneDefaults {
  std::string backend = "auto";
  int threads = 0;
  Limits limits;
  bool cuda = false;  ///< whether a CUDA device can be used
};

/// Checks a request for a scene. Throws InvalidInput, Unimplemented, LimitExceeded,
/// FailedPrecondition.
ScenePlan parse_scene(const pb::CreateSceneRequest& request, const SceneDefaults& defaults);

/// Appends a packed uint32[n][3] array; `path` names it in messages. Throws InvalidInput.
void parse_triangles(std::string_view bytes, uint32_t vertex_count, const std::string& path,
                     Scene::Triangles& triangles);

/// Checks what the frame overrides of its scene. The spans point into `frame`, which must outlive the result.
/// Throws InvalidInput, Unimplemented.
FrameInput parse_frame(const pb::Frame& frame, const SceneSpec& scene);

/// Bytes of positions in a frame.
uint64_t position_bytes(const pb::Frame& frame);

void fill_scene(const Scene& scene, pb::Scene* out);
void fill_device(const DeviceInfo& device, pb::Device* out);
void fill_limits(const Limits& limits, pb::ServerLimits* out);

/// What a frame cost outside the engine.
struct FrameCost {
  double total_milliseconds = 0, queue_milliseconds = 0;
  uint64_t device_bytes = 0, bytes_in = 0, bytes_out = 0;
};

void fill_done(const FrameResult& result, const FrameCost& cost, pb::FrameDone* out);

/// Contacts as chunks whose arrays hold at most `max_bytes` together. What was not computed is left out.
std::vector<pb::ContactChunk> make_chunks(const FrameResult& result, const Topology& topology,
                                          const OutputFields& fields, size_t max_bytes);

/// Bytes of the contact arrays of chunks.
uint64_t array_bytes(const std::vector<pb::ContactChunk>& chunks);

}  // namespace collided::server
