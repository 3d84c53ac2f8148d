#pragma once
// Where a scene's vertices are: at t = 0 and t = 1 of the step in work, and in the last good frame. A throw at any
// point leaves the last good frame where state_.good says.

#include <optional>
#include <utility>
#include <vector>

#include "gpu/positions/blend.hpp"
#include "gpu/positions/slot.hpp"
#include "gpu/scene/rigid_meshes.hpp"
#include "gpu/state/buffers.hpp"

namespace collided {

template <Executor Exec, class Real>
class ResidentPositions {
 public:
  using Slot = SceneSlot<Exec, Real>;
  using Positions = Buffer<Vec3<Real>, Exec>;
  using Buffers = ResidentBuffers<Exec, Real>;
  enum class Good { kEnd, kStart, kSaved };
  struct State {
    FirstMeshes first;  ///< that have their first positions in the next frame
    bool has_frame = false;
    bool has_path = false;   ///< `start` and `end` are those of the last frame, good or a trial
    Good good = Good::kEnd;  ///< which buffer has the last good frame's positions: `end`, `start` or `last_good`
  };
  /// All that is known of them on the host.
  struct Saved {
    State state;
    typename RigidMeshes<Exec, Real>::State rigid;
  };

  ResidentPositions(Exec& exec, const SceneShape& shape, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        shape_(shape),
        scene_(scene),
        rigid_(exec, shape, scene),
        state_{.first = FirstMeshes(shape.meshes(), true)} {}

  const FirstMeshes& first() const { return state_.first; }
  bool has_frame() const { return state_.has_frame; }
  /// Whether the scene's boxes of static meshes are those of the last good frame.
  bool are_boxes_good() const { return has_frame() && state_.good == Good::kEnd; }

  /// Of the last good frame.
  const Positions& last_good() const { return last_good(scene_, state_); }

  Saved save() const { return {state_, rigid_.state()}; }
  /// The buffers are what they were when this was saved.
  void restore(Saved saved) {
    state_ = std::move(saved.state);
    rigid_.restore(std::move(saved.rigid));
  }

  /// The meshes and buffers are those of an edit, which leaves all but the `first` meshes where they were; those have
  /// their first positions in the next frame. The others are copied from the `buffers` of before, where the meshes
  /// began at `vertex_offset`.
  void edit(const Saved& saved, const Buffers& buffers, const std::vector<uint32_t>& vertex_offset, FirstMeshes first) {
    state_ = {.first = std::move(first), .has_frame = true};
    scene_.end.allocate(vertices());
    if (!has_paths()) scene_.last_good.allocate(vertices());
    const Vec3<Real>* from = last_good(buffers, saved.state).data();
    for (size_t mesh = 0; mesh < state_.first.size(); ++mesh) {
      if (state_.first[mesh]) continue;
      copy_mesh(mesh, scene_.end.data(), from + vertex_offset[mesh]);
      if (!has_paths()) copy_mesh(mesh, scene_.last_good.data(), from + vertex_offset[mesh]);
    }
    rigid_.edit(saved.rigid, buffers.rigid.rest, state_.first);
  }

  /// Of a set of worlds: what the frame does with each.
  void begin_worlds(const WorldFrames& frames) {
    scene_.worlds.stepped = frames.count();
    exec_.upload(scene_.worlds.frame.data(), frames.frame().data(), frames.frame().size());
  }

  /// Memory for a frame. Not before the first, which brings all positions: a number of vertices alone holds none.
  void require(const Slot& slot, const FrameInput& frame) {
    require(scene_.end);
    if (has_paths()) require(scene_.start);
    if (!has_paths() || slot.brings_starts() || frame.start_fraction) require(scene_.last_good);
    if (frame.advance) scene_.target.allocate(vertices());
    rigid_.require();
  }

  /// Puts the frame's positions in `end`, and those that it begins at in `start`.
  void place(Slot& slot, const FrameInput& frame, bool is_ccd) {
    if (frame.start_fraction)
      begin_along(*frame.start_fraction);
    else if (has_frame())
      begin_at_last_good(slot.brings_starts());
    state_.has_path = false;
    rigid_.begin(frame.start_fraction);
    slot.place(exec_, scene_.start.data(), scene_.end.data(), !has_frame(), scene_.worlds.frame.data());
    if (frame.edit && has_paths()) begin_where_they_end(slot);
    rigid_.place(slot.moves(), is_ccd);
  }
  /// Tells the backend how rigid meshes turn on the whole way.
  void tell_turns() { rigid_.tell_turns(); }
  /// From here on the scene may go a part of the way.
  void keep_target() { copy(scene_.target, scene_.end); }
  /// Goes from `start` towards where `end` was when it was kept, as far as `ways` has the fractions of the vertices'
  /// groups.
  void go() {
    exec_.for_each("blend_each", vertices(),
                   BlendEach<Real>{scene_.start.data(), scene_.target.data(), scene_.topology.group_of.data(),
                                   scene_.ways.fractions.data(), scene_.end.data()});
  }
  bool has_rigid() const { return rigid_.has_any(); }
  /// The same of rigid meshes, by their poses. group_of(mesh): of all of its vertices.
  template <class GroupOf>
  void go_rigid(const GroupOf& group_of) {
    if (!has_rigid()) return;
    std::vector<double> fractions(vertices());
    exec_.download(fractions.data(), scene_.ways.fractions.data(), fractions.size() * sizeof(double));
    rigid_.go([&](uint32_t mesh) { return fractions[group_of(mesh)]; });
  }
  /// As RigidMeshes has it.
  double off_straight() const { return rigid_.off_straight(); }
  const Vec3<Real>* target() const { return scene_.target.data(); }

  /// The frame counts from here on; its positions are what a later failure falls back to.
  void commit(Slot& slot) {
    if (!has_paths()) {
      slot.place(exec_, nullptr, scene_.last_good.data(), false, scene_.worlds.frame.data());
      rigid_.place_ends(slot.moves(), scene_.last_good.data());
    }
    rigid_.commit();
    if (shape_.spec.worlds == 0) state_.first.assign(state_.first.size(), false);
    state_.has_frame = state_.has_path = true;
    state_.good = Good::kEnd;
  }
  /// The same where the worlds that it counts for are these.
  void commit(Slot& slot, const WorldFrames& frames) {
    commit(slot);
    for (uint32_t mesh = 0; mesh < state_.first.size(); ++mesh)
      if (frames.steps(shape_.world_of(mesh))) state_.first[mesh] = false;
  }
  /// The frame does not count, but the next one may begin on its way.
  void end_trial() { state_.has_path = state_.has_frame; }

  /// Throws InvalidInput where there is no way of a last frame.
  void check_start_fraction(const std::optional<double>& fraction) const {
    if (fraction && !state_.has_path)
      throw InvalidInput("start_fraction", "start_fraction is given, but the scene has no last frame to begin on");
    if (const auto mesh = rigid_.turning(); fraction && mesh)
      throw InvalidInput("start_fraction", "start_fraction is given, but mesh " + std::to_string(*mesh) +
                                               " turned in the last frame: it has no straight way to begin on");
  }

 private:
  bool has_paths() const { return shape_.spec.mode != Mode::kDcd; }
  uint32_t vertices() const { return shape_.vertex_offset.back(); }
  static const Positions& last_good(const Buffers& buffers, const State& state) {
    return state.good == Good::kEnd ? buffers.end : state.good == Good::kStart ? buffers.start : buffers.last_good;
  }

  void begin_at_last_good(bool brings_starts) {
    if (state_.good != Good::kEnd) copy(scene_.end, last_good());
    state_.good = Good::kEnd;
    if (has_paths()) begin_at_end(brings_starts);
    if (!has_paths()) state_.good = Good::kSaved;
  }
  /// CCD: a step begins where the last one ended, unless the frame `brings_starts`, which must not overwrite the only
  /// copy of the last good frame.
  void begin_at_end(bool brings_starts) {
    if (brings_starts) copy(scene_.last_good, scene_.end);
    copy(scene_.start, scene_.end);
    state_.good = brings_starts ? Good::kSaved : Good::kStart;
  }
  /// Meshes that an edit brought, without positions at t = 0.
  void begin_where_they_end(const Slot& slot) {
    for (uint32_t mesh = 0; mesh < first().size(); ++mesh)
      if (first()[mesh] && !slot.brings_start_of(mesh))
        copy_mesh(mesh, scene_.start.data(), scene_.end.data() + shape_.vertex_offset[mesh]);
  }
  void begin_along(double fraction) {
    if (state_.good != Good::kSaved) copy(scene_.last_good, last_good());
    state_.good = Good::kSaved;
    blend_into(scene_.start, scene_.start, scene_.end, fraction);
    copy(scene_.end, scene_.start);
  }

  /// A world that no frame has brought yet is nowhere, but not in memory of others.
  void require(Positions& positions) {
    const bool is_new = positions.capacity() == 0;
    positions.allocate(vertices());
    if (is_new && shape_.spec.worlds > 0) exec_.fill_zero(positions.data(), uint64_t{vertices()} * sizeof(Vec3<Real>));
  }
  void copy(Positions& to, const Positions& from) {
    exec_.copy(to.data(), from.data(), uint64_t{vertices()} * sizeof(Vec3<Real>));
  }
  /// The vertices of one mesh, to where the scene has them.
  void copy_mesh(size_t mesh, Vec3<Real>* to, const Vec3<Real>* from) {
    exec_.copy(to + shape_.vertex_offset[mesh], from,
               uint64_t{shape_.mesh(static_cast<uint32_t>(mesh)).vertex_count} * sizeof(Vec3<Real>));
  }
  void blend_into(Positions& out, const Positions& from, const Positions& to, double fraction) {
    exec_.for_each("blend_positions", vertices(), BlendPositions<Real>{from.data(), to.data(), fraction, out.data()});
  }

  Exec& exec_;
  const SceneShape& shape_;
  SceneBuffers<Exec, Real>& scene_;
  RigidMeshes<Exec, Real> rigid_;
  State state_;
};

}  // namespace collided
