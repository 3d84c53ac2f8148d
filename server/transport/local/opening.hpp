#pragma once
// The first packet of a local stream: the client, its terms, and the memory it shares.

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
  std::shared_ptr<void> ticket;  ///< counts the stream as open
  SceneUse scene;
  StreamTerms terms;
  std::unique_ptr<MemoryHold> region_bytes;  ///< charged to the client
  std::shared_ptr<SharedRegion> region;      ///< null: everything goes in packets
};

/// What openings are checked against; outlives them.
struct OpeningRules {
  SceneHost& host;
  const Authenticator& authenticator;
  bool cuda_ipc = false;
};

/// Checks the opening and maps its memory. Throws exceptions that map to the codes of StreamFrames.
Opening check_opening(const pb::LocalOpen& open, std::vector<PassedFile> files, const OpeningRules& rules,
                      const Origin& origin = {});

}  // namespace collided::server
