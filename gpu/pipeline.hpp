#pragma once
// The paper's Fig. 7 for one frame: positions that are resident in, contacts in canonical order out.
// enqueue() names the steps in their order; a scene runs those that its spec requires. The backend runs them without
// asking the host; lists that turn out too short are enlarged to the need and the step runs again.

#include <utility>
#include <vector>

#include "gpu/broad_phase.hpp"
#include "gpu/engine_choice.hpp"
#include "gpu/exec/step_key.hpp"
#include "gpu/lbvh_phase.hpp"
#include "gpu/narrow_phase.hpp"
#include "gpu/recently.hpp"
#include "gpu/refinement.hpp"
#include "gpu/results.hpp"
#include "gpu/sinks.hpp"

namespace collided {

template <class Exec, class Real>
class Pipeline {
 public:
  Pipeline(Exec& exec, const SceneSpec& spec, const Topology& topology, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        spec_(spec),
        topology_(topology),
        ranks_(ranks_of(spec, topology)),
        scene_(scene),
        broad_(exec, spec, topology, scene),
        lbvh_(exec, spec, topology, scene),
        narrow_(exec, spec, ranks_, scene),
        results_(exec, spec, ranks_, scene),
        choice_(spec.engine) {}

  /// `all`: the boxes of static meshes too are out of date.
  FrameResult detect_contacts(const std::vector<TriangleRun>& moved, bool all, const FrameSettings& settings) {
    result_ = {};
    needs_ = needs_of(spec_, settings);
    narrow_.begin(needs_);
    run_step(moved, all);
    describe();
    results_.collect(state_, needs_, result_);
    result_.stages = exec_.stage_times();
    result_.allocations = exec_.allocations();
    return std::move(result_);
  }

  uint64_t answer_bytes() const { return results_.answer_bytes(); }

 private:
  /// In pair tests. From 0 to 4 it makes no difference to the time beyond 2 % in all (tests/bench/results, registration
  /// weight); with 0 no other cut of the same grid makes fewer tests.
  static constexpr float kRegistrationCost = 0;

  static FeatureRanks ranks_of(const SceneSpec& spec, const Topology& topology) {
    const uint64_t vertices = topology.vertex_count, edges = topology.edges.size();
    const uint64_t count = vertices + edges + (spec.triangle_triangle ? topology.triangles.size() : 0);
    if (count >= ~0u)
      throw InvalidInput("meshes", "meshes have " + std::to_string(count) +
                                       " vertices, edges and triangles, the limit is " + std::to_string(~0u - 1));
    return {static_cast<uint32_t>(vertices), static_cast<uint32_t>(vertices + edges), static_cast<uint32_t>(count)};
  }

  /// Runs the step until everything it found had room.
  void run_step(const std::vector<TriangleRun>& moved, bool all) {
    scene_.state.allocate(1);
    for (;;) {
      const OctreePlan plan = plan_octree();
      reserve(plan);
      narrow_.reserve();
      state_ = exec_.step(key_of(all, plan), scene_.state.data(), [&] { enqueue(moved, plan); });
      const bool grown = broad_.grow(state_), grown_too = narrow_.grow(state_),
                 missed_large = large_.surprises(state_.large > 0) && !plan.has_large;
      // A step that was short of room tells nothing of what refinement is good for.
      if (!grown && !grown_too && !missed_large && !needs_refinement(plan)) break;
      ++result_.replays;
    }
  }

  bool needs_refinement(const OctreePlan& plan) {
    return plan.engine == Engine::kOctree && refinement_.observe(state_, topology_.triangles.size());
  }

  void reserve(const OctreePlan& plan) {
    if (plan.engine == Engine::kLbvh) return lbvh_.reserve();
    broad_.reserve(plan);
    exec_.upload(scene_.octree.wanted.data(), &levels_, sizeof(levels_));
  }

  /// Fig. 7.
  void enqueue(const std::vector<TriangleRun>& moved, const OctreePlan& plan) {
    exec_.stage("boxes", [&] { exec_.beside([&] { broad_.box_triangles(moved); }, [&] { broad_.clear(plan); }); });
    exec_.stage("levels", [&] { choose_levels(plan); });
    const auto build = [&] { plan.engine == Engine::kLbvh ? build_hierarchy() : build_octree(plan); };
    if (needs_.judges_resolution() && needs_.settings.delta == 0)
      exec_.beside(build, [&] { broad_.count_small_triangles(); });
    else
      build();
    if (spec_.vertex_triangle || spec_.edge_edge) detect_features(plan);
    if (spec_.triangle_triangle) detect_triangles(plan);
    narrow_.order();
  }

  void build_octree(const OctreePlan& plan) {
    exec_.stage("count", [&] { broad_.count_overlapped_cells(plan); });
    if (plan.rounds > 0) exec_.stage("refine", [&] { broad_.refine(plan); });
    exec_.stage("bottom_up", [&] { broad_.cut(plan); });
    exec_.stage("top_down", [&] { broad_.place_leaves(plan); });
    exec_.stage("registration", [&] { broad_.register_triangles(plan); });
  }
  void build_hierarchy() {
    exec_.stage("sort", [&] { lbvh_.sort(); });
    exec_.stage("hierarchy", [&] { lbvh_.build(); });
  }

  void choose_levels(const OctreePlan& plan) {
    if (plan.engine == Engine::kLbvh)
      lbvh_.measure();
    else if (has_cells_of_triangles(plan.engine))
      broad_.choose_cells(plan);
    else
      broad_.choose_levels();
  }
  /// Whether the spacing of the positions' numbers, at the largest of them, is coarser than delta; without a delta,
  /// than a thousandth of most triangles.
  bool is_coarse() const {
    if (needs_.settings.delta > 0) return spacing_at<Real>(state_.bounds) > needs_.settings.delta;
    return 2 * state_.small_triangles > topology_.triangles.size();
  }

  void detect_features(const OctreePlan& plan) {
    const auto narrow_vt = [&] { narrow_.detect(VertexTriangle{scene_.topology.triangles.all()}); };
    const auto narrow_ee = [&] { narrow_.detect(EdgeEdge{scene_.topology.edges.all()}); };
    const bool vt = spec_.vertex_triangle, ee = spec_.edge_edge;
    if (!needs_.has_narrow_phase()) return search(plan, vt, ee);
    if (vt && ee && needs_.is_any_hit()) {  // one kind may answer for both
      search(plan, true, false);
      narrow_vt();
      search(plan, false, true);
      narrow_ee();
      return;
    }
    search(plan, vt, ee);
    if (vt && ee)
      exec_.beside(narrow_vt, narrow_ee);
    else
      vt ? narrow_vt() : narrow_ee();
  }

  /// 6.-8. Pairs, their features' boxes, and the filter of the level.
  void search(const OctreePlan& plan, bool vertex_triangle, bool edge_edge) {
    exec_.stage("pairs", [&] {
      with_filter<Real>(needs_, spec_.thickness, scene_.state.data(),
                        [&](const auto& keep) { search_for(plan, keep, vertex_triangle, edge_edge); });
    });
  }
  template <class Keep>
  void search_for(const OctreePlan& plan, const Keep& keep, bool vertex_triangle, bool edge_edge) {
    StepState* state = scene_.state.data();
    const auto list = [&](int kind) -> AppendList<uint64_t> {
      if (!needs_.has_narrow_phase()) return {scene_.contacts.keys.all(), &state->contacts};
      return {scene_.kept[kind].all(), &state->kept[kind]};
    };
    const uint32_t edge_rank = needs_.has_narrow_phase() ? 0 : ranks_.first_edge;
    find_pairs("find_candidates", plan,
               FeatureSink<Real, Keep>{broad_.elementary(vertex_triangle, edge_edge),
                                       keep,
                                       list(kVertexTriangleKind),
                                       list(kEdgeEdgeKind),
                                       edge_rank,
                                       narrow_.hurry(),
                                       {vertex_triangle || !spec_.vertex_triangle ? &state->pairs : nullptr,
                                        &state->candidates[0], &state->candidates[1]}},
               vertex_triangle || !spec_.vertex_triangle ? Search::kFeatures : Search::kEdges);
  }

  void detect_triangles(const OctreePlan& plan) {
    StepState* state = scene_.state.data();
    const bool narrow = needs_.tests_triangles(), counts = !spec_.vertex_triangle && !spec_.edge_edge;
    exec_.stage("pairs_tt", [&] {
      const AppendList<uint64_t> list = narrow
                                            ? AppendList<uint64_t>{scene_.triangle_pairs.all(), &state->triangle_pairs}
                                            : AppendList<uint64_t>{scene_.contacts.keys.all(), &state->contacts};
      find_pairs("find_triangle_pairs", plan,
                 TrianglePairSink{scene_.topology.triangles.all(),
                                  list,
                                  narrow ? 0 : ranks_.first_triangle,
                                  narrow_.hurry(),
                                  {counts ? &state->pairs : nullptr, nullptr, nullptr}},
                 Search::kTriangles);
    });
    if (narrow) narrow_.detect_triangles();
  }

  template <class Sink>
  void find_pairs(const char* name, const OctreePlan& plan, const Sink& sink, Search search) {
    uint64_t* next_item = &scene_.state.data()->next_item[static_cast<int>(search)];
    plan.engine == Engine::kLbvh ? lbvh_.search(name, sink, next_item) : broad_.search(name, plan, sink, next_item);
  }

  OctreePlan plan_octree() const {
    const Engine engine = choice_.engine();
    OctreePlan plan{engine, {cut_rule_of(engine), kRegistrationCost}};
    if (has_cells_of_triangles(engine))
      plan.levels = engine == Engine::kUniformGrid ? 1 : kLevelsOfCrowdedCell + 1;
    else if (levels_.base >= 0)
      plan.levels = levels_.base - levels_.top + 1, plan.base = levels_.base;
    plan.has_large = large_.is_expected() || !Exec::kLaunchesCost;
    if (engine != Engine::kOctree) return plan;
    plan.rounds = refinement_.rounds();
    plan.most_crowded_tests = refinement_.limit(topology_.triangles.size());
    return plan;
  }
  StepKey key_of(bool all, const OctreePlan& plan) const {
    return {static_cast<double>(needs_.settings.accuracy),
            needs_.settings.delta,
            static_cast<double>(needs_.settings.report),
            all ? 1.0 : 0.0,
            static_cast<double>(plan.engine),
            static_cast<double>(plan.rounds),
            static_cast<double>(plan.levels),
            static_cast<double>(plan.base),
            plan.has_large ? 1.0 : 0.0,
            narrow_.expects_many() ? 1.0 : 0.0,
            static_cast<double>(plan.most_crowded_tests)};
  }

  /// Counts of the step, and what follows from them for the next.
  void describe() {
    FrameCounts& c = result_.counts;
    const LeafTotals& leaves = state_.leaves;
    c.cells = leaves.cells, c.leaves = leaves.leaves, c.registrations = leaves.registrations, c.tests = leaves.tests;
    c.top_level = static_cast<uint32_t>(state_.grid.grid.top);
    c.base_level = static_cast<uint32_t>(state_.grid.grid.base);
    c.pairs = state_.pairs;
    c.candidates_vt = state_.candidates[0], c.candidates_ee = state_.candidates[1];
    if (needs_.has_filter()) c.survivors_vt = state_.kept[0], c.survivors_ee = state_.kept[1];
    result_.engine = choice_.engine();
    if (result_.engine == Engine::kLbvh)
      lbvh_.describe(c);
    else if (!has_cells_of_triangles(result_.engine))
      levels_ = next_levels({state_.grid.grid.top, state_.grid.grid.base}, leaves.level_registrations);
    if (needs_.settings.report != Report::kAnyHit) choice_.observe(c, topology_.triangles.size(), state_.bricks[0] > 0);
    result_.input_resolution = needs_.judges_resolution() && is_coarse();
    result_.step_milliseconds = exec_.step_milliseconds();
    result_.graph_launches = exec_.graph_launches();
  }

  Exec& exec_;
  const SceneSpec& spec_;
  const Topology& topology_;
  const FeatureRanks ranks_;
  SceneBuffers<Exec, Real>& scene_;
  BroadPhase<Exec, Real> broad_;
  LbvhPhase<Exec, Real> lbvh_;
  NarrowPhase<Exec, Real> narrow_;
  Results<Exec, Real> results_;
  EngineChoice choice_;
  Refinement refinement_;
  ActiveLevels levels_;
  Recently large_;  ///< triangles that cover many cells
  LevelNeeds needs_;
  StepState state_{};
  FrameResult result_;
};

}  // namespace collided
