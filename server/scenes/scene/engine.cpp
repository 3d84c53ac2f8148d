// The engine's side of a scene: its detector from the building to the release, the slots of its frames, its turns on
// the devices.
#include "server/scenes/scene/engine.hpp"

#include <spdlog/fmt/fmt.h>

#include <cstddef>
#include <new>
#include <span>

#include "server/errors.hpp"
#include "server/refusals/field_path.hpp"

namespace collided::server {
namespace {

// Ids rise strictly, from 1.
void check_frame_id(uint64_t frame_id, uint64_t last_frame_id) {
  if (frame_id == 0) throw InvalidInput("frame.frame_id", "frame.frame_id is 0, but ids start at 1");
  if (frame_id <= last_frame_id)
    throw FailedPrecondition("frame.frame_id",
                             fmt::format("frame.frame_id is {}, but must be greater than {}, the last frame applied",
                                         frame_id, last_frame_id));
}

std::vector<Turns*> turns_on(ServedDevices& served, const SceneSpec& spec) {
  std::vector<Turns*> turns;
  for (const Device& device : devices_of(spec)) turns.push_back(&served.turns(device));
  return turns;
}

}  // namespace

SceneEngine::SceneEngine(SceneRecord& record, SceneUploads& uploads, const SceneQuota& quota, ServedDevices& devices)
    : record_(record),
      uploads_(uploads),
      quota_(quota.whole),
      turns_(turns_on(devices, record.plan()->engine), record.identity().owner->turn_path()),
      host_turns_({&devices.host_turns()}, record.identity().owner->turn_path()),
      held_(quota_) {}

// A pool gives no slot once it is closed. Before that an edit has replaced it, or the release has taken it away.
std::shared_ptr<FrameSlot> SceneEngine::take_slot() {
  const auto pool = [this] {
    const std::lock_guard lock(mutex_);
    return slots_;
  };
  while (const auto slots = pool())
    if (auto slot = slots->take()) return slot;
  record_.check_open();
  uploads_.throw_awaits("scene_id");
}

void SceneEngine::build_if_complete() {
  record_.check_open();
  if (uploads_.awaits_any()) return;
  make_detector();
  {
    const std::lock_guard lock(mutex_);
    slots_ = std::make_shared<SlotPool>(detector_);
  }
  record_.show(*detector_, held_.bytes());
}

void SceneEngine::make_detector() try {
  const auto is_closed = [this] { return record_.is_closed(); };
  auto turn = host_turns_.take(is_closed);
  detector_ = naming_paths(spec_path, [&] {
    return Detector::create(uploads_.take_spec(held_), [&] {
      turn.yield_turn(is_closed);
      return is_closed();
    });
  });
  held_.resize(host_bytes(*record_.plan()));
} catch (const Cancelled&) {
  record_.check_open();
  throw;
} catch (...) {
  build_failure_ = std::current_exception();
  throw;
}

void SceneEngine::check_built() const {
  if (build_failure_) std::rethrow_exception(build_failure_);
}

uint64_t SceneEngine::host_bytes(const ScenePlan& plan) const {
  return plan_bytes(plan) + count_tables(plan.engine) * topology_bytes(detector_->topology());
}

FrameResult SceneEngine::apply(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis) {
  record_.check_open();
  if (!detector_) uploads_.throw_awaits("scene_id");
  check_frame_id(frame_id, record_.last_frame_id());
  if (basis.plan && basis.plan != record_.plan()) throw_edited(frame_id);
  samples_.clear();
  FrameResult result = naming_paths(frame_path, [&] { return detect(frame_id, frame, basis); });
  if (!frame.trial) record_.show_frame(frame_id);
  try {
    record_.show(*detector_, held_.bytes());
  } catch (const std::bad_alloc&) {  // the frame was applied; its successor will tell what the scene holds
  }
  return result;
}

FrameResult SceneEngine::detect(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis) try {
  if (!frame.edit) return detector_->detect(frame);
  MemoryHold making(quota_);
  // Once the engine has applied the edit nothing may fail.
  making.resize(count_tables(record_.plan()->engine) * max_edit_bytes(*frame.edit));
  FrameResult result = detector_->detect(frame);
  take_edit(basis, making);
  return result;
} catch (const InvalidInput& e) {
  if (e.field() == "slot") throw_edited(frame_id);  // taken while the edit was in work
  throw;
}

void SceneEngine::throw_edited(uint64_t frame_id) const {
  throw FailedPrecondition("frame",
                           fmt::format("frame {} came before scene {} was edited by frame {}, and does not fit "
                                       "it any more; send it again",
                                       frame_id, record_.id(), record_.last_frame_id()));
}

// The engine has applied the edit. The plan is shown last, because a thread that sees it may use the slots and the
// uploads of its meshes at once.
void SceneEngine::take_edit(const FrameBasis& basis, MemoryHold& making) {
  auto plan = std::make_shared<const ScenePlan>(edited_plan(*record_.plan(), basis.edited, detector_->spec()));
  auto slots = std::make_shared<SlotPool>(detector_);
  uploads_.set_mesh_count(plan->meshes.size());
  {
    const std::lock_guard lock(mutex_);
    slots_.swap(slots);
  }
  record_.show_edit(plan, detector_->topology().vertex_count);
  if (slots) slots->close();
  held_.absorb(making);
  held_.resize(host_bytes(*plan));
}

std::shared_ptr<const std::string> SceneEngine::positions(const VertexSample& sample) {
  record_.check_open();
  for (const auto& [before, positions] : samples_)
    if (before == sample) return positions;
  std::string bytes(sample.count * position_bytes(record_.plan()->engine.scalar), '\0');
  if (sample.count > 0) detector_->read_positions(sample, std::as_writable_bytes(std::span(bytes)));
  samples_.emplace_back(sample, std::make_shared<const std::string>(std::move(bytes)));
  return samples_.back().second;
}

void SceneEngine::release() {
  std::shared_ptr<SlotPool> slots;
  {
    const std::lock_guard lock(mutex_);
    slots.swap(slots_);
  }
  if (slots) slots->close();
  samples_.clear();
  detector_.reset();
  held_.resize(0);
}

}  // namespace collided::server
