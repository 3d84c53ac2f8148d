// Admission of a client's frame.
#include "server/frames/intake.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "server/convert/chunks.hpp"
#include "server/convert/edit.hpp"
#include "server/convert/options.hpp"
#include "server/errors.hpp"
#include "server/refusals/field_path.hpp"
#include "server/sets/set_frame.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFrameId = std::numeric_limits<int64_t>::max();

// The slot reads from the message, or from where it was placed, until the frame has been applied.
void send_positions(Scene& scene, std::shared_ptr<FrameSlot> slot, PendingFrame& frame) {
  if (!slot) slot = scene.engine().take_slot();
  naming_paths(frame_path, [&] { slot->send(frame.input.updates); });
  frame.input.updates.clear();
  frame.input.slot = std::move(slot);
}

void note_updates(PendingFrame& frame) {
  for (const MeshPositions& update : frame.input.updates) {
    frame.meshes.push_back({update.mesh, !update.is_sparse, !update.end.empty()});
    frame.bytes_in += update.start.size() + update.end.size() + update.indices.size() + update.transform.size() +
                      update.start_transform.size();
  }
}

void take_frame(const pb::Frame& message, const IncomingFrame& incoming, PendingFrame& frame) {
  check_no_worlds(message);
  frame.input = parse_frame(message, incoming.placed, frame.basis.plan->engine);
  note_updates(frame);
}

void take_set_frame(const pb::Frame& message, const IncomingFrame& incoming, PendingFrame& frame) {
  SetFrameInput parsed = parse_set_frame(message, incoming.placed, frame.basis.plan->engine);
  frame.input = std::move(parsed.input);
  frame.worlds = std::move(parsed.worlds);
  for (const uint32_t mesh : parsed.meshes) frame.meshes.push_back({mesh});
  frame.bytes_in = position_bytes_of(frame.input);
  frame.tells_worlds = true;
}

// What lies in a slot already is in one piece unless there are starts, which lie before all ends.
void send_set(Scene& set, std::shared_ptr<FrameSlot> slot, FrameInput& input) {
  const auto has_start = [](const MeshPositions& update) { return !update.start.empty(); };
  if (!slot || std::ranges::any_of(input.updates, has_start)) return send_in_one_piece(set, input);
  naming_paths(frame_path, [&] { slot->send(input.updates); });
  input.updates.clear();
  input.slot = std::move(slot);
}

// What the input refers to, until the frame has been applied.
struct Kept {
  Kept(IncomingFrame& frame, const Scene& scene)
      : message(std::move(frame.message)), memory(std::move(frame.memory)), elements(scene.quota()) {}

  const pb::Frame message;
  const std::shared_ptr<const void> memory;
  std::shared_ptr<FrameSlot> slot;
  MemoryHold elements;  // of an edit
};

// The positions of an edit fit the scene that it makes, so the engine takes them from where they are.
void take_edit(const SceneHost& host, Kept& kept, PendingFrame& frame) {
  kept.elements.resize(2 * element_bytes(kept.message.edit()));  // in the message, and for the engine
  ParsedEdit edit = parse_edit(kept.message.edit(), *frame.basis.plan, host.limits());
  frame.input.edit = std::move(edit.engine);
  frame.basis.edited = std::move(edit.meshes);
}

}  // namespace

void check_frame_id(uint64_t id) {
  if (id > kMaxFrameId)
    throw InvalidInput("frame.frame_id", fmt::format("frame.frame_id is {}, more than {}", id, kMaxFrameId));
}

void send_in_one_piece(Scene& set, FrameInput& input) {
  std::shared_ptr<FrameSlot> slot = set.engine().take_slot();
  naming_paths(frame_path, [&] {
    move_to(slot->room(position_bytes_of(input)), input);
    slot->send(input.updates);
  });
  input.updates.clear();
  input.slot = std::move(slot);
}

PendingFrame admit_frame(SceneHost& host, Scene& scene, IncomingFrame incoming) {
  const auto kept = std::make_shared<Kept>(incoming, scene);
  const pb::Frame& message = kept->message;
  PendingFrame frame;
  frame.basis.plan = scene.plan();
  try {
    if (incoming.refusal) std::rethrow_exception(incoming.refusal);
    check_frame_id(message.frame_id());
    host.usage().count_frame(scene.identity().owner);
    const bool is_set = frame.basis.plan->engine.worlds > 0;
    if (is_set)
      take_set_frame(message, incoming, frame);
    else
      take_frame(message, incoming, frame);
    const Accuracy max = scene.identity().owner->limits.max_accuracy;
    if (frame.input.accuracy) check_max_accuracy(*frame.input.accuracy, max, "frame.accuracy");
    if (is_set) {
      send_set(scene, std::move(incoming.slot), frame.input);
    } else if (message.has_edit()) {
      kept->slot = std::move(incoming.slot);
      take_edit(host, *kept, frame);
    } else {
      send_positions(scene, std::move(incoming.slot), frame);
    }
    frame.input.bytes_beside_contact = incoming.answer_bytes_per_contact + (is_set ? sizeof(uint32_t) : 0);
    if (frame.input.limits)
      frame.input.bytes_beside_contact =
          std::max(frame.input.bytes_beside_contact, uint64_t{kLimitFields.contact_bytes()});
    const OutputFields& fields = frame.basis.plan->fields;
    frame.input.room = {incoming.room, fields.columns, fields.stencils};
  } catch (...) {
    frame.refusal = std::current_exception();
    frame.input = {};
  }
  frame.frame_id = message.frame_id();
  frame.memory = kept;
  frame.arrival = incoming.arrival;
  frame.decode_milliseconds = milliseconds_since(incoming.arrival);
  return frame;
}

}  // namespace collided::server
