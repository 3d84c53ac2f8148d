// A frame of a client on its way into the daemon.
#include "server/convert/frame_intake.hpp"

#include <limits>
#include <utility>

#include "server/convert/convert_level.hpp"
#include "server/convert/refuse.hpp"
#include "server/scenes/field_path.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFrameId = std::numeric_limits<int64_t>::max();

// The slot reads from the message, or from where it was placed, until the frame has been applied.
void send_positions(Scene& scene, std::shared_ptr<FrameSlot> slot, PendingFrame& frame) {
  if (!slot) slot = scene.take_slot();
  try {
    slot->send(frame.input.updates);
  } catch (const InvalidInput& e) {
    throw with_path(e, frame_path);
  } catch (const ResourceExhausted& e) {
    throw_if_budget(e);
    throw;
  }
  frame.input.updates.clear();
  frame.input.slot = std::move(slot);
}

// Ids only rise, so that the largest would be the scene's last. Negative numbers end up beyond the limit.
void check_frame_id(uint64_t id) {
  if (id > kMaxFrameId)
    throw InvalidInput("frame.frame_id", fmt::format("frame.frame_id is {}, more than {}", id, kMaxFrameId));
}

}  // namespace

PendingFrame admit_frame(SceneHost& host, Scene& scene, IncomingFrame incoming) {
  PendingFrame frame;
  const auto message = std::make_shared<const pb::Frame>(std::move(incoming.message));
  try {
    if (incoming.refusal) std::rethrow_exception(incoming.refusal);
    check_frame_id(message->frame_id());
    host.usage().count_frame(scene.facts().owner);
    const Accuracy most = scene.facts().owner->limits.max_accuracy;
    frame = parse_frame(*message, incoming.placed, scene.plan().engine);
    if (frame.input.accuracy) check_most(*frame.input.accuracy, most, "frame.accuracy");
    send_positions(scene, std::move(incoming.slot), frame);
    frame.input.bytes_beside_contact = incoming.bytes_beside_contact;
  } catch (...) {
    frame.refusal = std::current_exception();
    frame.input = {};
  }
  frame.frame_id = message->frame_id();
  frame.memory = message;
  frame.arrival = incoming.arrival;
  frame.decode_milliseconds = milliseconds_since(incoming.arrival);
  return frame;
}

}  // namespace collided::server
