#pragma once
// Answers of a local stream: contacts go into the output region while they fit, everything else into packets. Those
// that the device has put there are only named.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "collided/v1/local.pb.h"
#include "server/frames/frame.hpp"
#include "server/refusals/status.hpp"
#include "server/scenes/scene.hpp"
#include "server/transport/local/shared_region.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// One packet from the daemon.
std::string to_packet(pb::StreamFramesResponse response);

/// The last packet of a stream.
std::string closed_packet(const Failure& why);

/// The answer to the opening. Without the scene's meshes if the packet would be too long.
std::string opened_packet(const Scene& scene, uint32_t window);

class AnswerWriter {
 public:
  /// `region` may be null; `window` is 1 or more.
  AnswerWriter(std::shared_ptr<SharedRegion> region, uint32_t window);

  /// The packets of a frame's answer, in order. Completes the frame's cost. Called once for each frame, in order;
  /// skip() stands in for a frame without contacts.
  std::vector<std::string> write(const Scene& scene, AnsweredFrame& frame);
  void skip() { ++frames_; }

 private:
  const std::shared_ptr<SharedRegion> region_;
  const uint32_t window_;
  uint64_t frames_ = 0;  ///< answered so far
};

}  // namespace collided::server
