#pragma once
// A resident scene: its plan, its detector, its worker, and what others may see of it. No gRPC here.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/scenes/scene_worker.hpp"

namespace collided::server {

/// Contact fields that the scene's clients want.
struct OutputFields {
  bool elements = false, stencils = false, toi = false, distance = false, weights = false, flags = false;
  /// Bytes of one contact's arrays.
  size_t contact_bytes() const {
    return elements * 8u + stencils * 16u + toi * 8u + distance * 8u + weights * 16u + flags * 1u;
  }
};

struct MeshPlan {
  std::string name;
  uint64_t awaited = 0;  ///< triangles that uploads will bring
};

/// A checked request for a scene.
struct ScenePlan {
  std::string display_name;
  OutputFields fields;
  std::vector<MeshPlan> meshes;
  SceneSpec engine;
};

/// What a scene shows of itself at one moment.
struct SceneSnapshot {
  bool ready = false;
  std::string device;
  uint64_t vertices = 0, edges = 0, triangles = 0;
  std::vector<MemoryPart> memory;
  uint64_t last_frame_id = 0;
};

class Scene {
 public:
  using Triangles = std::vector<std::array<uint32_t, 3>>;

  Scene(std::string id, ScenePlan plan, size_t queue_capacity);

  const std::string& id() const { return id_; }
  /// The plan without its triangles.
  const ScenePlan& plan() const { return plan_; }
  SceneWorker& worker() { return worker_; }
  SceneSnapshot snapshot() const;
  /// Triangles of a mesh that are still to come.
  uint64_t awaited(uint32_t mesh) const;
  /// Keeps a mesh for one upload, so that open uploads hold no more than the scene awaits. Throws FailedPrecondition.
  void begin_upload(uint32_t mesh);
  void end_upload(uint32_t mesh);
  /// Whether all triangles came and still made no detector.
  bool unusable() const;
  /// Frames and uploads that come after this are answered with NotFound.
  void close() { closed_ = true; }

  // On the worker's thread only:

  /// Makes the detector if no triangles are awaited.
  void build_if_complete();
  /// Adds all triangles that a mesh awaits, and makes the detector with the last ones.
  void add_triangles(uint32_t mesh, const Triangles& triangles);
  /// Checks and applies a frame; a throw leaves the scene as it was.
  FrameResult apply(uint64_t frame_id, const FrameInput& frame);
  const Topology& topology() const { return detector_->topology(); }
  /// Frees the scene's memory.
  void release() { detector_.reset(); }

 private:
  void check_open() const;
  bool awaits_triangles() const;
  void publish();

  const std::string id_;
  ScenePlan plan_;
  SceneSpec pending_;  // the spec with its triangles, until the detector takes it
  std::unique_ptr<Detector> detector_;
  std::atomic<bool> closed_ = false;
  mutable std::mutex mutex_;  // guards the three below
  SceneSnapshot shown_;
  std::vector<uint64_t> awaited_;
  std::vector<bool> uploading_;
  SceneWorker worker_;  // last: its thread ends before the rest goes
};

}  // namespace collided::server
