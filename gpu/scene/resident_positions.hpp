#pragma once
// Where a scene's vertices are: at t = 0 and t = 1 of the step in work, and in the last good frame. A throw at any
// point leaves the last good frame where good_ says.

#include <optional>

#include "gpu/positions/blend.hpp"
#include "gpu/positions/slot.hpp"
#include "gpu/scene/rigid_meshes.hpp"
#include "gpu/step/buffers.hpp"

namespace collided {

template <Executor Exec, class Real>
class ResidentPositions {
 public:
  using Slot = SceneSlot<Exec, Real>;
  using Positions = Buffer<Vec3<Real>, Exec>;

  ResidentPositions(Exec& exec, const SceneShape& shape, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        spec_(shape.spec),
        vertices_(shape.vertex_offset.back()),
        scene_(scene),
        rigid_(exec, shape, scene) {}

  bool has_frame() const { return has_frame_; }
  /// Whether the scene's boxes of static meshes are those of the last good frame.
  bool are_boxes_good() const { return has_frame_ && good_ == Good::kEnd; }

  /// Of the last good frame.
  const Positions& last_good() const {
    return good_ == Good::kEnd ? scene_.end : good_ == Good::kStart ? scene_.start : scene_.last_good;
  }

  /// Memory for a frame. Not before the first, which brings all positions: a number of vertices alone holds none.
  void require(const Slot& slot, const FrameInput& frame) {
    scene_.end.allocate(vertices_);
    if (has_paths()) scene_.start.allocate(vertices_);
    if (!has_paths() || slot.brings_starts() || frame.start_fraction) scene_.last_good.allocate(vertices_);
    if (frame.advance) scene_.target.allocate(vertices_);
    rigid_.require();
  }

  /// Puts the frame's positions in `end`, and those that it begins at in `start`.
  void place(Slot& slot, const std::optional<double>& start_fraction, bool is_ccd) {
    if (start_fraction)
      begin_along(*start_fraction);
    else if (has_frame_)
      begin_at_last_good(slot.brings_starts());
    has_path_ = false;
    rigid_.begin(start_fraction);
    slot.place(exec_, scene_.start.data(), scene_.end.data(), !has_frame_);
    rigid_.place(slot.moves(), !has_frame_, is_ccd);
  }
  /// A mesh that turns in the step in work: its true path is no straight one.
  std::optional<uint32_t> turning() const { return rigid_.turning(); }

  /// From here on the scene may go a part of the way.
  void keep_target() { copy(scene_.target, scene_.end); }
  /// Goes this far from `start` to where `end` was when it was kept.
  void go(double fraction) {
    blend_into(scene_.end, scene_.start, scene_.target, fraction);
    rigid_.go(fraction);
  }

  /// The frame counts from here on; its positions are what a later failure falls back to.
  void commit(Slot& slot) {
    if (!has_paths()) {
      slot.place(exec_, nullptr, scene_.last_good.data(), false);
      rigid_.place_ends(slot.moves(), scene_.last_good.data());
    }
    rigid_.commit();
    has_frame_ = has_path_ = true;
    good_ = Good::kEnd;
  }
  /// The frame does not count, but the next one may begin on its way.
  void end_trial() { has_path_ = has_frame_; }

  /// Throws InvalidInput where there is no way of a last frame.
  void check_start_fraction(const std::optional<double>& fraction) const {
    if (fraction && !has_path_)
      throw InvalidInput("start_fraction", "start_fraction is given, but the scene has no last frame to begin on");
    if (const auto mesh = rigid_.turning(); fraction && mesh)
      throw InvalidInput("start_fraction", "start_fraction is given, but mesh " + std::to_string(*mesh) +
                                               " turned in the last frame: it has no straight way to begin on");
  }

 private:
  enum class Good { kEnd, kStart, kSaved };
  bool has_paths() const { return spec_.mode != Mode::kDcd; }

  void begin_at_last_good(bool brings_starts) {
    if (good_ != Good::kEnd) copy(scene_.end, last_good());
    good_ = Good::kEnd;
    if (has_paths()) begin_at_end(brings_starts);
    if (!has_paths()) good_ = Good::kSaved;
  }
  /// CCD: a step begins where the last one ended, unless the frame `brings_starts`, which must not overwrite the only
  /// copy of the last good frame.
  void begin_at_end(bool brings_starts) {
    if (brings_starts) copy(scene_.last_good, scene_.end);
    copy(scene_.start, scene_.end);
    good_ = brings_starts ? Good::kSaved : Good::kStart;
  }
  void begin_along(double fraction) {
    if (good_ != Good::kSaved) copy(scene_.last_good, last_good());
    good_ = Good::kSaved;
    blend_into(scene_.start, scene_.start, scene_.end, fraction);
    copy(scene_.end, scene_.start);
  }

  void copy(Positions& to, const Positions& from) {
    exec_.copy(to.data(), from.data(), uint64_t{vertices_} * sizeof(Vec3<Real>));
  }
  void blend_into(Positions& out, const Positions& from, const Positions& to, double fraction) {
    exec_.for_each("blend_positions", vertices_, BlendPositions<Real>{from.data(), to.data(), fraction, out.data()});
  }

  Exec& exec_;
  const SceneSpec& spec_;
  const uint32_t vertices_;
  SceneBuffers<Exec, Real>& scene_;
  RigidMeshes<Exec, Real> rigid_;
  bool has_frame_ = false;
  bool has_path_ = false;   ///< `start` and `end` are those of the last frame, good or a trial
  Good good_ = Good::kEnd;  ///< which buffer has the last good frame's positions: `end`, `start` or `last_good`
};

}  // namespace collided
