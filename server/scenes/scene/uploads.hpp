#pragma once
// The triangles of a scene that has yet to be built: those that have come, and how many are awaited. No gRPC here.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "gpu/detector.hpp"
#include "server/scenes/scene/plan.hpp"
#include "server/scenes/scene/record.hpp"

namespace collided::server {

/// Triangles that one upload has received so far. They count against the scene's memory as they arrive, not when they
/// are declared.
class ReceivedTriangles {
 public:
  explicit ReceivedTriangles(std::shared_ptr<MemoryQuota> quota) : held_(std::move(quota)) {}

  /// Accounts for `count` more, before push(). Throws LimitExceeded.
  void reserve(uint64_t count) { held_.resize(held_.bytes() + count * sizeof(TriangleCorners)); }
  void push(const TriangleCorners& triangle) { triangles_.push_back(triangle); }
  uint64_t size() const { return triangles_.size(); }
  /// Appends them to `mesh` and their bytes to `held`.
  void move_to(std::vector<TriangleCorners>& mesh, MemoryHold& held);

 private:
  std::deque<TriangleCorners> triangles_;  // a vector would hold up to three times as much while it grows
  MemoryHold held_;
};

/// A mutex guards which meshes await triangles and which are being sent; the triangles that have come are the worker's.
class SceneUploads {
 public:
  /// `spec`: with its triangles. Throws LimitExceeded if they and the record's plan alone exceed the quota. `record`
  /// outlives this.
  SceneUploads(const SceneRecord& record, SceneSpec spec, const SceneQuota& quota);

  /// Number of triangles that a mesh still awaits.
  uint64_t awaited(uint32_t mesh) const;
  /// True until all triangles have arrived.
  bool awaits_any() const;
  /// Throws FailedPrecondition, naming `field` and the triangles that the scene awaits.
  [[noreturn]] void throw_awaits(const std::string& field) const;
  /// Reserves a mesh for one upload, so that open uploads hold no more than the scene awaits. Throws
  /// FailedPrecondition.
  void begin(uint32_t mesh);
  void end(uint32_t mesh);

  // The worker's thread alone calls these:

  /// Takes all triangles that a mesh awaits. Throws NotFound once the scene is closed, FailedPrecondition,
  /// InvalidInput for another number of them.
  void add(uint32_t mesh, ReceivedTriangles& triangles);
  /// Returns the spec with its triangles, and moves the bytes held for them and for the plan to `held`.
  SceneSpec take_spec(MemoryHold& held);
  /// An edit is about to add meshes, whose triangles it has brought.
  void set_mesh_count(size_t meshes);
  /// Frees the memory.
  void release();

 private:
  const SceneRecord& record_;
  MemoryHold held_;           // of the plan and the triangles
  SceneSpec pending_;         // until the detector takes it
  mutable std::mutex mutex_;  // guards what follows
  std::vector<uint64_t> awaited_;
  std::vector<bool> uploading_;
};

}  // namespace collided::server
