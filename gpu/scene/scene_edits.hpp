#pragma once
// Frames that edit their scene: the scene stays as edited if the frame counts, and else as it was.

#include <algorithm>
#include <utility>

#include "gpu/scene/edit.hpp"
#include "gpu/scene/resident_positions.hpp"
#include "gpu/scene/rest_pairs.hpp"
#include "gpu/scene/scene_model.hpp"
#include "gpu/scene/solid_volumes.hpp"
#include "gpu/step/pipeline.hpp"
#include "gpu/tables/tables.hpp"

namespace collided {

template <Executor Exec, class Real>
class SceneEdits {
 public:
  SceneEdits(Exec& exec, SceneModel<Exec, Real>& model, ResidentPositions<Exec, Real>& positions,
             Pipeline<Exec, Real>& pipeline, RestPairs<Exec, Real>& rest_pairs, SolidVolumes<Exec, Real>& volumes)
      : exec_(exec),
        model_(model),
        positions_(positions),
        pipeline_(pipeline),
        rest_pairs_(rest_pairs),
        volumes_(volumes) {}

  /// Edits the scene as the frame says; detect() then finds the contacts of the edited one.
  template <class Detect>
  FrameResult apply(const FrameInput& frame, bool is_ccd, const Detect& detect) {
    if (!positions_.has_frame())
      throw InvalidInput("edit", "edit is given in the scene's first frame, which has its meshes by the scene's spec");
    Parts before(exec_);
    Saved saved = positions_.save();
    bool is_begun = false;
    try {
      exec_.stage("edit", [&] {
        MemoryHold making(model_.spec().memory_quota);
        EditedScene edited = edit_scene(model_.spec(), model_.topology(), frame, is_ccd);
        FeatureTables features = make(edited, making);
        model_.swap(before);
        is_begun = true;
        begin(std::move(edited), std::move(features), before, saved);
      });
      FrameResult result = detect();
      release_unneeded();
      return result;
    } catch (...) {
      if (is_begun) undo(before, std::move(saved));
      throw;
    }
  }

 private:
  using Parts = typename SceneModel<Exec, Real>::Parts;
  using Saved = typename ResidentPositions<Exec, Real>::Saved;

  FeatureTables make(const EditedScene& edited, MemoryHold& making) {
    if (edited.changes_features) return make_tables(edited.spec, making, exec_.asks());
    FeatureTables features;
    features.rings = make_rings(edited.spec, model_.topology(), making, exec_.asks());
    return features;
  }
  void begin(EditedScene edited, FeatureTables features, const Parts& before, const Saved& saved) {
    if (edited.changes_features)
      model_.take(std::move(edited.spec), std::move(features));
    else
      model_.take_rules(std::move(edited.spec), before, features.rings);
    pipeline_.resize(model_.topology());
    positions_.edit(saved, before.buffers, before.shape.vertex_offset, std::move(edited.first));
    rest_pairs_.edit(before.buffers.topology.rest_pairs, IdShift(before.topology, model_.topology()),
                     edited.begins_at_rest);
    volumes_.expect(std::move(edited.new_solids));
  }
  void undo(Parts& before, Saved saved) {
    model_.swap(before);
    pipeline_.resize(model_.topology());
    positions_.restore(std::move(saved));
    rest_pairs_.settle();
    volumes_.settle();
  }
  /// Releases lists that a much larger scene needed.
  void release_unneeded() {
    const size_t triangles = model_.topology().triangles.size();
    most_triangles_ = std::max(most_triangles_, triangles);
    if (2 * triangles > most_triangles_) return;
    most_triangles_ = triangles;
    pipeline_.release_lists();
  }

  Exec& exec_;
  SceneModel<Exec, Real>& model_;
  ResidentPositions<Exec, Real>& positions_;
  Pipeline<Exec, Real>& pipeline_;
  RestPairs<Exec, Real>& rest_pairs_;
  SolidVolumes<Exec, Real>& volumes_;
  size_t most_triangles_ = model_.topology().triangles.size();  ///< since lists were released
};

}  // namespace collided
