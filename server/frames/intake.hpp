#pragma once
// A frame of a client on its way into the daemon, whichever transport it came by: counted, checked, sent to the
// backend.

#include <exception>
#include <memory>
#include <vector>

#include "collided/v1/frame.pb.h"
#include "server/convert/frame.hpp"
#include "server/frames/frame.hpp"
#include "server/scenes/scene_host.hpp"

namespace collided::server {

/// A frame as it came.
struct IncomingFrame {
  Clock::time_point arrival = Clock::now();
  pb::Frame message;
  std::vector<PlacedPositions> placed;  ///< as for parse_frame()
  std::shared_ptr<FrameSlot> slot;      ///< taken already if `placed` refers to its memory; else null
  std::shared_ptr<const void> memory;   ///< keeps alive what `placed` refers to otherwise; may be null
  std::exception_ptr refusal;           ///< what went wrong before; may be null
  size_t answer_bytes_per_contact = 0;  ///< that the transport holds until the client has taken them
};

/// Never throws: what is wrong with the frame becomes its refusal, to be told in its turn.
PendingFrame admit_frame(SceneHost& host, Scene& scene, IncomingFrame incoming);

}  // namespace collided::server
