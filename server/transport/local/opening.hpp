#pragma once
// The first packet of a local stream: who the client is, what it may have, and which memory it shares.

#include <cstdint>
#include <memory>
#include <vector>

#include "collided/v1/local.pb.h"
#include "server/auth/authenticator.hpp"
#include "server/frames/messages.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/transport/local/packets.hpp"
#include "server/transport/local/shared_region.hpp"

namespace collided::server {

/// What a local stream uses once it is open.
struct Opening {
  Client client;
  std::shared_ptr<void> ticket;  ///< for an open stream of the client
  SceneUse scene;
  StreamTerms terms;
  std::unique_ptr<MemoryHold> region_bytes;  ///< counted as the client's
  std::shared_ptr<SharedRegion> region;      ///< null: everything is in packets
};

/// What openings are checked against. Outlives them.
struct OpeningRules {
  SceneHost& host;
  const Authenticator& authenticator;
  bool cuda_ipc = false;
};

/// Checks the opening and maps its memory. Throws as the codes of StreamFrames say.
Opening check_opening(const pb::LocalOpen& open, std::vector<PassedFile> files, const OpeningRules& rules);

}  // namespace collided::server
