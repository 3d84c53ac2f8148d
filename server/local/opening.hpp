#pragma once
// The first packet of a local stream: who the client is, what it may have, and the memory that it shares.

#include <cstdint>
#include <memory>
#include <vector>

#include "collided/v1/local.pb.h"
#include "server/auth/authenticator.hpp"
#include "server/local/packets.hpp"
#include "server/local/shared_region.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/service/stream_messages.hpp"

namespace collided::server {

/// What a local stream works with once it is open.
struct Opening {
  Client client;
  std::shared_ptr<void> place;  ///< among the client's streams
  SceneUse scene;
  OpenedStream stream;
  std::unique_ptr<MemoryHold> region_bytes;  ///< taken from what the client's scenes may hold
  std::shared_ptr<SharedRegion> region;      ///< null: everything is in the packets
};

/// What openings are checked against. Outlives them.
struct OpeningRules {
  SceneHost& host;
  const Authenticator& authenticator;
  bool cuda_ipc = false;
};

/// Checks the opening and maps its memory. Throws what the codes of StreamFrames stand for.
Opening check_opening(const pb::LocalOpen& open, std::vector<PassedFile> files, const OpeningRules& rules);

/// Bytes of input region that frames of a scene can need: positions, indices and, for many meshes, their message.
uint64_t most_input_bytes(const Scene& scene, uint32_t window);
/// Bytes that the message of a frame can need whose positions are elsewhere.
uint64_t most_message_bytes(const SceneSpec& scene);

}  // namespace collided::server
