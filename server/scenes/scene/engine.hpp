#pragma once
// The engine's side of a scene: its detector from the building to the release, the slots of its frames, its turns on
// the devices. No gRPC here.

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "gpu/detector.hpp"
#include "server/devices/served_devices.hpp"
#include "server/devices/turns_of_scene.hpp"
#include "server/scenes/scene/plan.hpp"
#include "server/scenes/scene/record.hpp"
#include "server/scenes/scene/slot_pool.hpp"
#include "server/scenes/scene/uploads.hpp"

namespace collided::server {

/// A mutex guards the slots, which any thread takes; all else is the worker's. No lock is held while the engine works.
class SceneEngine {
 public:
  /// The record, the uploads and the devices outlive this.
  SceneEngine(SceneRecord& record, SceneUploads& uploads, const SceneQuota& quota, ServedDevices& devices);

  /// Returns a free or new slot for one frame; its last reference returns it to the scene. From any thread. Throws
  /// NotFound once the scene is deleted, FailedPrecondition before it is built.
  std::shared_ptr<FrameSlot> take_slot();
  /// Later frames take turns of this client: the one that sends them. From any thread.
  void charge_to(const TurnPath& client) { turns_.charge_to(client); }

  // The worker's thread alone calls these:

  /// Builds the detector, in turns of its client on the host, unless triangles are still missing.
  void build_if_complete();
  /// Throws what its building failed with.
  void check_built() const;
  /// Waits for this scene's turn on its devices.
  TurnsOfScene::Turn take_turn(const std::function<bool()>& cancelled) { return turns_.take(cancelled); }
  /// Checks and applies a frame; if it throws, the scene is unchanged. Throws FailedPrecondition if the scene was
  /// edited since the frame was checked.
  FrameResult apply(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis = {});
  const Topology& topology() const { return detector_->topology(); }
  /// Positions after the last frame that was applied, in the scene's format; those who ask for the same sample of one
  /// frame share them. Throws NotFound once the scene is deleted, ResourceExhausted, LimitExceeded, DeviceError.
  std::shared_ptr<const std::string> positions(const VertexSample& sample);
  /// Frees the memory.
  void release();

 private:
  void make_detector();
  FrameResult detect(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis);
  [[noreturn]] void throw_edited(uint64_t frame_id) const;
  void take_edit(const FrameBasis& basis, MemoryHold& making);
  uint64_t host_bytes(const ScenePlan& plan) const;

  SceneRecord& record_;
  SceneUploads& uploads_;
  const std::shared_ptr<DeviceBytes> quota_;
  TurnsOfScene turns_, host_turns_;  // of frames, and of building
  MemoryHold held_;                  // of the plan and the topology, from the building on
  std::exception_ptr build_failure_;
  std::shared_ptr<Detector> detector_;
  std::vector<std::pair<VertexSample, std::shared_ptr<const std::string>>> samples_;  // of the last frame
  std::mutex mutex_;                                                                  // guards what follows
  std::shared_ptr<SlotPool> slots_;  // null until there is a detector, and once it is released
};

}  // namespace collided::server
