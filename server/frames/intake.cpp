// Admission of a client's frame.
#include "server/frames/intake.hpp"

#include <spdlog/fmt/fmt.h>

#include <limits>
#include <utility>

#include "server/convert/edit.hpp"
#include "server/convert/options.hpp"
#include "server/errors.hpp"
#include "server/refusals/field_path.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFrameId = std::numeric_limits<int64_t>::max();

// The slot reads from the message, or from where it was placed, until the frame has been applied.
void send_positions(Scene& scene, std::shared_ptr<FrameSlot> slot, PendingFrame& frame) {
  if (!slot) slot = scene.take_slot();
  naming_paths(frame_path, [&] { slot->send(frame.input.updates); });
  frame.input.updates.clear();
  frame.input.slot = std::move(slot);
}

void check_takes_frames(const Scene& scene, const SceneSpec& spec) {
  if (spec.worlds > 0)
    throw FailedPrecondition("scene_id", fmt::format("scene_id: scene {} is a set of {} scenes, whose frames come by "
                                                     "DetectBatch",
                                                     scene.id(), spec.worlds));
}

void note_updates(PendingFrame& frame) {
  for (const MeshPositions& update : frame.input.updates) {
    frame.meshes.push_back({update.mesh, !update.is_sparse, !update.end.empty()});
    frame.bytes_in += update.start.size() + update.end.size() + update.indices.size() + update.transform.size() +
                      update.start_transform.size();
  }
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

PendingFrame admit_frame(SceneHost& host, Scene& scene, IncomingFrame incoming) {
  const auto kept = std::make_shared<Kept>(incoming, scene);
  const pb::Frame& message = kept->message;
  PendingFrame frame;
  frame.basis.plan = scene.plan();
  try {
    if (incoming.refusal) std::rethrow_exception(incoming.refusal);
    check_takes_frames(scene, frame.basis.plan->engine);
    check_frame_id(message.frame_id());
    host.usage().count_frame(scene.facts().owner);
    frame.input = parse_frame(message, incoming.placed, frame.basis.plan->engine);
    const Accuracy max = scene.facts().owner->limits.max_accuracy;
    if (frame.input.accuracy) check_max_accuracy(*frame.input.accuracy, max, "frame.accuracy");
    note_updates(frame);
    if (message.has_edit()) {
      kept->slot = std::move(incoming.slot);
      take_edit(host, *kept, frame);
    } else {
      send_positions(scene, std::move(incoming.slot), frame);
    }
    frame.input.bytes_beside_contact = incoming.answer_bytes_per_contact;
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
