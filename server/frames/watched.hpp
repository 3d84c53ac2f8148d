#pragma once
// A frame as its scene's watchers see it.

#include <cstdint>

#include "collided/v1/frame.pb.h"
#include "server/frames/frame.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Immutable, shared by all watchers of the scene.
struct WatchedFrame {
  uint64_t frame_id = 0;
  uint64_t edits = 0;  ///< of the scene, up to this frame
  pb::FrameDone done;  ///< with the first contacts of each kind, as many as the most demanding watcher shows
};

/// How many contacts of each kind the most demanding watcher shows; 0 if nobody watches.
uint32_t most_watched(const SceneWatchers& watchers);

/// Shows the frame, whose cost must be complete, to the scene's watchers. On the scene's worker. Never throws: what
/// goes wrong ends the watches, not the frame.
void tell_watchers(const Scene& scene, const AnsweredFrame& frame);

}  // namespace collided::server
