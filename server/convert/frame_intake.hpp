#pragma once
// A frame of a client on its way into the daemon, whichever transport it came by: counted, checked, sent to the
// backend.

#include <chrono>
#include <exception>
#include <memory>
#include <vector>

#include "server/convert/convert.hpp"
#include "server/scenes/scene_host.hpp"

namespace collided::server {

/// A frame as it came.
struct IncomingFrame {
  std::chrono::steady_clock::time_point arrival = std::chrono::steady_clock::now();
  pb::Frame message;
  std::vector<PlacedPositions> placed;  ///< as for parse_frame()
  std::shared_ptr<FrameSlot> slot;      ///< taken already if `placed` lies in it; else null
  std::exception_ptr refusal;           ///< what went wrong before; may be null
  size_t bytes_beside_contact = 0;      ///< that the transport holds for each contact until the client has taken it
};

/// Never throws: what is wrong with the frame becomes its refusal, to be told in its turn.
PendingFrame admit_frame(SceneHost& host, Scene& scene, IncomingFrame incoming);

}  // namespace collided::server
