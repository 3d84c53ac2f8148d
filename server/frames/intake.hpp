#pragma once
// Admission of a client's frame from any transport: counted, checked, positions sent to the backend.

#include <exception>
#include <memory>
#include <span>
#include <vector>

#include "collided/v1/frame.pb.h"
#include "server/convert/frame.hpp"
#include "server/frames/frame.hpp"
#include "server/scenes/scene_host.hpp"

namespace collided::server {

/// A frame as received.
struct IncomingFrame {
  Clock::time_point arrival = Clock::now();
  pb::Frame message;
  std::vector<PlacedPositions> placed;  ///< as for parse_frame()
  std::shared_ptr<FrameSlot> slot;      ///< set if `placed` refers to its memory; else null
  std::shared_ptr<const void> memory;   ///< keeps alive other memory that `placed` refers to; may be null
  std::exception_ptr refusal;           ///< an earlier error; may be null
  size_t answer_bytes_per_contact = 0;  ///< held by the transport until the client has taken them
  std::span<std::byte> room = {};       ///< of the device, where contacts stay; within `memory`
};

/// Frames with more bytes than this are read and checked in turns of their client on the host. Smaller ones are not: to
/// hand them over would cost more than it protects.
constexpr size_t kMaxUnsharedBytes = size_t{4} << 20;

/// Ids only rise: after the largest one, the scene could take no more frames. Negative ids wrap beyond the limit.
/// Throws InvalidInput.
void check_frame_id(uint64_t id);

/// Sends the positions of a set's frame from a slot of their own, each update's start and end, one update after the
/// other, so that they are brought to a device in one copy. Throws InvalidInput, NotFound, ResourceExhausted.
void send_in_one_piece(Scene& set, FrameInput& input);

/// Never throws: an error becomes the frame's refusal, which is sent in order.
PendingFrame admit_frame(SceneHost& host, Scene& scene, IncomingFrame incoming);

}  // namespace collided::server
