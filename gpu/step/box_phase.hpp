#pragma once
// Step 1 of Fig. 7, for every engine: boxes and records of all triangles, and the tests of features that go by them.
// The boxes of a step that makes lists of neighbours are wider by a margin.

#include <vector>

#include "gpu/base/precision.hpp"
#include "gpu/boxes/boxes.hpp"
#include "gpu/boxes/resolution.hpp"
#include "gpu/search/elementary.hpp"
#include "gpu/state/context.hpp"

namespace collided {

template <Executor Exec, class Real>
class BoxPhase {
 public:
  explicit BoxPhase(const StepContext<Exec, Real>& context) : context_(context) {}

  /// The next steps have these needs. Boxes are no wider than they say until widen().
  void begin(const LevelNeeds& needs) {
    needs_ = needs;
    narrow();
  }
  /// From here on vertices end at `end`, and boxes are wider by `margin`, in the unit of the positions.
  void widen(double margin, const Vec3<Real>* end) { margin_ = round_up<Real>(margin), end_ = end; }
  /// Ends widen().
  void narrow() { margin_ = 0, end_ = nullptr; }

  /// Boxes `all` triangles, or those of meshes that move or are idle, whose boxes the last step removed.
  void box_triangles(bool all) {
    using Work = BoxTriangles<Real>;
    SceneBuffers<Exec, Real>& scene = context_.scene;
    for (const TriangleRun& run : runs(all))
      context_.exec.for_each_group(
          "box_triangles", {nullptr, (run.count + Work::kGroupSize - 1) / Work::kGroupSize},
          Work{motion(), deviations(), scene.topology.corners(), scene.topology.sides(), scene.topology.owned.all(),
               run.first, run.count, scene.boxes.all(), scene.records.all(), scene.paths.all(),
               scene.triangle_inflations(), margin_, scene.stepped_worlds(), scene.halves(needs_.settings)});
  }

  /// Counts the triangles that the spacing of the positions' numbers is too coarse for.
  void count_small_triangles() {
    StepState* state = context_.state();
    context_.exec.for_each("count_small_triangles", context_.triangles(),
                           CountSmall<Real>{&state->bounds, context_.scene.triangle_records(), &state->small_triangles,
                                            context_.scene.stepped_worlds()});
  }
  /// After a step: returns true if the spacing of the positions' numbers, at the largest of them, is coarser than
  /// delta; without a delta, than a thousandth of most triangles.
  bool is_coarse(const StepState& step) const {
    if (needs_.settings.delta > 0) return spacing_at<Real>(step.bounds) > needs_.settings.delta;
    const SceneCounts& counts = context_.counts;
    const uint64_t judged = counts.triangles - counts.loose_points;
    const uint64_t worlds = max(counts.worlds, 1u), stepped = counts.worlds > 0 ? context_.scene.worlds.stepped : 1;
    return 2 * step.small_triangles > judged / worlds * stepped;
  }

  ElementaryTests<Real> elementary(const PerKind<bool>& wanted) const {
    return {context_.scene.triangle_records(),
            context_.scene.topology.owned.all(),
            {widened(motion().inflation, margin_)},
            wanted.vertex_triangle,
            wanted.edge_edge};
  }
  /// The same where boxes are inflated by more in some meshes, or some elements are no triangles.
  ElementaryTests<Real, InflationByTriangle<Real>, MixedElements> elementary_of_any(const PerKind<bool>& wanted) const {
    return {context_.scene.triangle_records(),
            context_.scene.topology.owned.all(),
            {widened(motion().inflation, margin_), context_.scene.triangle_inflations()},
            wanted.vertex_triangle,
            wanted.edge_edge};
  }

 private:
  /// Returns what boxes are wider by. In a frame that advances, meshes may go any part of their ways.
  Deviations deviations() const {
    const Deviations of_step = context_.scene.deviations(needs_.is_ccd());
    return needs_.advances ? of_step.of_parts() : of_step;
  }
  /// Triangles [first, first + count).
  struct TriangleRun {
    uint64_t first, count;
  };
  std::vector<TriangleRun> runs(bool all) const {
    const SceneCounts& counts = context_.counts;
    const std::vector<MeshSpec>& meshes = context_.spec.meshes;
    if (counts.worlds > 0) return {{0, counts.triangles}};  // whichever are static
    std::vector<TriangleRun> runs;
    for (uint32_t mesh = 0; mesh < meshes.size(); ++mesh) {
      const bool is_boxed = meshes[mesh].motion == MeshMotion::kStatic && !context_.scene.topology.idle.has(mesh);
      if (!all && is_boxed) continue;
      const uint64_t first = counts.triangle_offset[mesh], end = counts.triangle_offset[mesh + 1];
      if (!runs.empty() && runs.back().first + runs.back().count == first)
        runs.back().count += end - first;
      else
        runs.push_back({first, end - first});
    }
    return runs;
  }
  Motion<Real> motion() const {
    const Real half = static_cast<Real>(needs_.reach()) / 2;
    const SceneBuffers<Exec, Real>& scene = context_.scene;
    return {scene.positions_at_start(needs_.is_ccd()), end_ != nullptr ? end_ : scene.end.data(),
            half == 0 ? half : next_up(half)};
  }

  const StepContext<Exec, Real>& context_;
  LevelNeeds needs_;
  Real margin_ = 0;
  const Vec3<Real>* end_ = nullptr;  ///< null: where the scene's vertices do
};

}  // namespace collided
