#pragma once
// What the phases of a scene's steps share.

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/search/searcher.hpp"
#include "gpu/state/buffers.hpp"
#include "gpu/state/level_needs.hpp"

namespace collided {

/// Everything outlives the phases.
template <Executor Exec, class Real>
struct StepContext {
  Exec& exec;
  Searcher<Exec>& searcher;
  const SceneSpec& spec;
  const SceneCounts& counts;
  SceneBuffers<Exec, Real>& scene;

  uint64_t triangles() const { return counts.triangles; }
  StepState* state() const { return scene.state.data(); }
  Span<const Box<float>> boxes() const { return scene.boxes.span(triangles()); }
  SceneSize size() const { return scene.size(triangles()); }

  /// Sets up the narrow phase once the bounds of the scene are known.
  PrepareNarrow prepare_narrow(const LevelNeeds& needs) const {
    return {state(), needs.settings.reach_of_any_pair(), scene.deviations(needs.is_ccd())};
  }
  /// Measures the bounds of the scene, which is all that the narrow phase needs to know of it.
  void measure_bounds_alone(const LevelNeeds& needs) const {
    measure_bounds(exec, size(), prepare_narrow(needs));
    scene.leave_out_idle(exec, triangles());
  }
};

}  // namespace collided
