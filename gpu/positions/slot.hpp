#pragma once
// A frame's positions on their way to a scene: checked against its meshes, brought to the backend, checked there.

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "gpu/exec/concepts.hpp"
#include "gpu/exec/cpu/staging.hpp"
#include "gpu/positions/checks.hpp"
#include "gpu/positions/format.hpp"
#include "gpu/positions/runs.hpp"
#include "gpu/positions/world_frames.hpp"

namespace collided {

/// What a slot has to know of its scene, which it may outlive.
struct SceneShape {
  SceneSpec spec;                       ///< meshes without their triangles
  std::vector<uint32_t> vertex_offset;  ///< of each mesh of each world; one more entry at the end

  /// Of each world's: world w has mesh m as number w * meshes_of_world() + m.
  uint32_t meshes_of_world() const { return static_cast<uint32_t>(spec.meshes.size()); }
  uint32_t meshes() const { return meshes_of_world() * count_worlds(spec); }
  const MeshSpec& mesh(uint32_t number) const { return spec.meshes[number % meshes_of_world()]; }
  uint32_t world_of(uint32_t mesh) const { return mesh / meshes_of_world(); }
  /// The number of the mesh that a vertex is of.
  uint32_t mesh_of(uint32_t vertex) const {
    const auto next = std::upper_bound(vertex_offset.begin(), vertex_offset.end(), vertex);
    return static_cast<uint32_t>(next - vertex_offset.begin()) - 1;
  }
};

template <Executor Exec, class Real>
class SceneSlot final : public FrameSlot {
 public:
  SceneSlot(std::shared_ptr<const SceneShape> shape, const Exec& exec)
      : shape_(std::move(shape)), quantization_(shape_->spec.quantized_in), staging_(exec.make_staging()) {}

  std::span<std::byte> room(uint64_t bytes) override {
    is_sent_ = false;
    return staging_.room(bytes);
  }

  /// `stream`: as FrameInput has it.
  void send_after(void* stream, const std::vector<MeshPositions>& updates) {
    staging_.follow(stream);
    send(updates);
  }

  void send(const std::vector<MeshPositions>& updates) override {
    is_sent_ = false;
    check_updates(shape_->spec, updates);
    bring(updates);
    const Real limit = static_cast<Real>(coordinate_limit(shape_->spec.scalar));
    staging_.check(positions_.count, count_worlds(shape_->spec), CheckPositions<Real>{positions_, limit},
                   CheckPositions<Real>{on_host(), limit});
    is_sent_ = true;
  }

  /// Whether some mesh has positions at t = 0.
  bool brings_starts() const {
    return std::any_of(runs_.begin(), runs_.end(), [](const auto& run) { return run.start != nullptr; }) ||
           std::any_of(moves_.begin(), moves_.end(), [](const auto& move) { return move.start.has_value(); });
  }
  /// Whether this mesh has.
  bool brings_start_of(uint32_t mesh) const {
    for (size_t i = 0; i < meshes_.size(); ++i)
      if (meshes_[i].mesh == mesh) return runs_[i].start != nullptr;
    return false;
  }
  const std::vector<RigidMove>& moves() const { return moves_; }

  bool is_of(const std::shared_ptr<const SceneShape>& shape) const { return shape_ == shape; }

  /// Waits for what was sent. Throws InvalidInput where the scene cannot take it.
  void arrive(const FirstMeshes& first) {
    if (!is_sent_) throw InvalidInput("slot", "slot brings no positions, they have to be sent first");
    check_turn(shape_->spec, meshes_, first);
    if (const uint64_t bad = staging_.first_bad()[0]; bad != kNoBadPlace) refuse(BadPosition::of(bad));
  }
  /// The same of a set, whose worlds are refused one by one.
  WorldFrames arrive_by_world(const FirstMeshes& first, Asks& asks) {
    if (!is_sent_) throw InvalidInput("slot", "slot brings no positions, they have to be sent first");
    WorldFrames frames(shape_->spec, meshes_, first, asks);
    const std::span<const uint64_t> bad = staging_.first_bad();
    for (uint32_t world = 0; world < bad.size(); ++world) {
      if (bad[world] == kNoBadPlace) continue;
      asks.ask_if_due();  // a refusal takes as long as the steps of many worlds
      frames.unless_refused(world, [&] { refuse(BadPosition::of(bad[world])); });
    }
    return frames;
  }

  /// Puts in line that they go where they belong; `start` may be null. `frame`: as PlacePositions has it.
  void place(Exec& exec, Vec3<Real>* start, Vec3<Real>* end, bool start_is_end, const uint8_t* frame) {
    exec.for_each("place_positions", positions_.count,
                  PlacePositions<Real>{positions_, start, end, start_is_end, frame});
    exec.done_with(staging_);
  }

 private:
  void bring(const std::vector<MeshPositions>& updates) {
    std::vector<Source> sources;
    for (const MeshPositions& update : updates)
      sources.insert(sources.end(), {update.indices, update.start, update.end});
    const std::vector<const std::byte*> places = staging_.bring(sources, alignof(Real));
    moves_ = moves_of(updates);
    meshes_.clear();
    runs_.clear();
    uint64_t count = 0;
    for (size_t i = 0; i < updates.size(); ++i) {
      const MeshPositions& update = updates[i];
      meshes_.push_back({update.mesh, update.is_sparse, !update.end.empty(), !update.transform.empty()});
      runs_.push_back({count, shape_->vertex_offset[update.mesh], shape_->mesh(update.mesh).vertex_count,
                       reinterpret_cast<const uint32_t*>(places[3 * i]), places[3 * i + 1], places[3 * i + 2],
                       shape_->world_of(update.mesh)});
      count += update.end.size() / position_bytes(shape_->spec);
    }
    positions_ = {{staging_.bring(runs_), runs_.size()}, count, quantization_};
  }

  [[noreturn]] void refuse(const BadPosition& bad) {
    const size_t update = on_host().run_of(bad.position);
    const PositionRun& run = runs_[update];
    const uint64_t k = bad.position - run.first;
    const uint32_t index = run.indices != nullptr ? staging_.read(run.indices + k) : static_cast<uint32_t>(k);
    const UpdatePlace place{update, name_of_mesh(shape_->spec, meshes_[update].mesh), k};
    if (bad.what == BadPosition::kIndex) refuse_index(place, index, run.vertex_count);
    const bool is_end = bad.what == BadPosition::kEnd;
    const Vec3<Real> p = staging_.read(reinterpret_cast<const Vec3<Real>*>(is_end ? run.end : run.start) + k);
    const Real value = bad.coordinate == 0 ? p.x : bad.coordinate == 1 ? p.y : p.z;
    refuse_coordinate(place, is_end, {index, bad.coordinate, value, coordinate_limit(shape_->spec.scalar)});
  }

  /// The frame's positions, by the host's own table.
  PositionRuns<Real> on_host() const { return {{runs_.data(), runs_.size()}, positions_.count, quantization_}; }

  std::shared_ptr<const SceneShape> shape_;
  const Quantization quantization_;
  typename Exec::Staging staging_;
  bool is_sent_ = false;
  std::vector<SentMesh> meshes_;
  std::vector<PositionRun> runs_;  ///< of each update
  std::vector<RigidMove> moves_;
  PositionRuns<Real> positions_;  ///< the runs on the backend
};

}  // namespace collided
