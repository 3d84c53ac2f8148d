#pragma once
// The paper's Fig. 7 for one frame: positions that are resident in, contacts in canonical order out.
// enqueue() names the steps in their order; a scene runs those that its spec requires. The backend runs them without
// asking the host; lists that turn out too short are enlarged to the need and the step runs again.

#include <optional>
#include <utility>

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/step/engine_choices.hpp"
#include "gpu/step/lbvh_phase.hpp"
#include "gpu/step/narrow_phase.hpp"
#include "gpu/step/octree_phase.hpp"
#include "gpu/step/placing.hpp"
#include "gpu/step/plan.hpp"
#include "gpu/step/refinement.hpp"
#include "gpu/step/results.hpp"
#include "gpu/step/sinks.hpp"
#include "gpu/step/usage_predictor.hpp"

namespace collided {

template <Executor Exec, class Real>
class Pipeline {
 public:
  Pipeline(Exec& exec, const SceneSpec& spec, SceneCounts counts, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        spec_(spec),
        counts_(std::move(counts)),
        ranks_(ranks_of(spec, counts_)),
        scene_(scene),
        searcher_(exec),
        octree_(exec, searcher_, spec, counts_, scene),
        lbvh_(exec, searcher_, counts_, scene),
        narrow_(exec, ranks_, scene),
        placing_(exec, scene),
        results_(exec, spec, scene, placing_),
        choices_(spec.engine),
        levels_{.deepest = deepest_base(counts_.triangles)} {
    narrow_.expect_loose_elements(counts_.has_loose_elements());
  }

  /// `boxes_static`: the boxes of static meshes too are out of date. `bytes_beside_contact`, `room`: as in FrameInput.
  FrameResult detect_contacts(bool boxes_static, const FrameSettings& settings, uint64_t bytes_beside_contact,
                              const ContactRoom& room = {}) {
    return detect(boxes_static, needs_of(spec_, settings, room), bytes_beside_contact, room);
  }
  /// The pairs that `needs_of_rest_pairs` says, as contacts.
  FrameResult detect_rest_pairs() { return detect(true, needs_of_rest_pairs(spec_), 0, {}); }

  /// The scene is made of so much from the next step on. Throws InvalidInput where that is too much.
  void resize(SceneCounts counts) {
    ranks_ = ranks_of(spec_, counts);
    counts_ = std::move(counts);
    const int deepest = deepest_base(counts_.triangles);
    if (deepest != levels_.deepest) levels_ = {.deepest = deepest};
    narrow_.expect_loose_elements(counts_.has_loose_elements());
    boxed_thickness_.reset();
    numbers_.begin_anew();
  }
  /// Lists shrink to what they begin with.
  void release_lists() {
    static_cast<WorkBuffers<Exec, Real>&>(scene_) = WorkBuffers<Exec, Real>(exec_);
    searcher_.release();
    placing_.begin_anew();
    sent_levels_ = {.deepest = -1};
    boxed_thickness_.reset();
  }

  /// Bounds of all triangles over the last step, rounded outward.
  const Box<float>& bounds() const { return state_.bounds; }
  uint64_t answer_bytes() const { return results_.answer_bytes(); }

 private:
  /// In pair tests. From 0 to 4 it makes no difference to the time beyond 2 % in all (tests/bench/results, registration
  /// weight); with 0 no other cut of the same grid makes fewer tests.
  static constexpr float kRegistrationCost = 0;

  FrameResult detect(bool boxes_static, const LevelNeeds& needs, uint64_t bytes_beside_contact,
                     const ContactRoom& room) {
    const double thickness = needs.settings.reach();
    result_ = {};
    placing_.begin(room);
    const bool is_boxed = std::exchange(boxed_thickness_, std::nullopt) == thickness;
    result_.broad_phase = choices_.begin(needs);
    run_step(needs, boxes_static || !is_boxed);
    boxed_thickness_ = thickness;
    describe();
    results_.collect(state_, needs, {bytes_beside_contact, room.first_on_host}, result_);
    result_.stages = exec_.stage_times();
    result_.allocations = exec_.allocations();
    choices_.end(result_, counts_.triangles, state_.bricks[0] > 0);
    release_idle_engines();
    return std::move(result_);
  }

  /// Whoever lost a comparison holds no memory.
  void release_idle_engines() {
    if (scene_.bvh.nodes.capacity() > 0 && choices_.is_idle(Engine::kLbvh)) scene_.bvh = BvhBuffers<Exec>(exec_);
    if (scene_.octree.counts.capacity() > 0 && choices_.is_idle(Engine::kOctree)) {
      scene_.octree = OctreeBuffers<Exec>(exec_);
      sent_levels_ = {.deepest = -1};
    }
  }

  static FeatureRanks ranks_of(const SceneSpec& spec, const SceneCounts& counts) {
    FeatureRanks ranks = {};
    uint64_t count = 0;
    for_each_kind(
        [&](ContactKind kind, bool is_wanted, uint64_t features) {
          if (is_wanted || is_of_features(kind)) count += features;
          ranks.begin[index_of(kind) + 1] = static_cast<uint32_t>(count);
        },
        spec.kinds, counts.first_features());
    if (count >= ~0u)
      throw InvalidInput("meshes", "meshes have " + std::to_string(count) +
                                       " vertices, edges and triangles, the limit is " + std::to_string(~0u - 1));
    return ranks;
  }

  const LevelNeeds& needs() const { return plan_.needs; }

  void run_step(const LevelNeeds& needs, bool boxes_static) {
    try {
      run_until_room(needs, boxes_static);
    } catch (const ResourceExhausted&) {
      const std::optional<EngineFacts> other = choices_.retreat();
      if (!other) throw;
      result_.broad_phase = *other;
      release_idle_engines();
      run_until_room(needs, boxes_static);
    } catch (...) {
      choices_.abandon();
      throw;
    }
  }
  /// Until everything the step found had room.
  void run_until_room(const LevelNeeds& needs, bool boxes_static) {
    scene_.state.allocate(1);
    for (;;) {
      plan_ = {needs, plan_octree(), boxes_static, narrow_.plan_order()};
      octree_.begin(needs.settings.reach(), needs.is_ccd());
      lbvh_.begin(needs.settings.reach(), needs.is_ccd());
      narrow_.begin(plan_);
      reserve();
      state_ = exec_.step(numbers_.number_of(plan_), scene_.state.data(), [&] { enqueue(); });
      if (!must_rerun()) return;
      ++result_.replays;
    }
  }

  /// Makes room for what the step asked for.
  bool must_rerun() {
    const bool octree_grew = octree_.grow(state_), narrow_grew = narrow_.grow(state_),
               missed_large = large_.observe(state_.large > 0) && !plan_.octree.has_large;
    // A step that was short of room tells nothing of what refinement is good for.
    return octree_grew || narrow_grew || missed_large || needs_refinement();
  }
  bool needs_refinement() {
    return plan_.octree.engine == Engine::kOctree && refinement_.observe(state_, counts_.triangles);
  }

  void reserve() {
    scene_.reserve_boxes(counts_.triangles);
    narrow_.reserve();
    if (is_lbvh()) return lbvh_.reserve();
    octree_.reserve(plan_.octree);
    if (std::exchange(sent_levels_, levels_) == levels_) return;
    exec_.upload(scene_.octree.wanted.data(), &sent_levels_, sizeof(sent_levels_));
  }
  bool is_lbvh() const { return plan_.octree.engine == Engine::kLbvh; }

  /// Fig. 7.
  void enqueue() {
    exec_.stage("boxes", [&] {
      exec_.concurrently([&] { octree_.box_triangles(plan_.boxes_static); }, [&] { octree_.clear(plan_.octree); });
    });
    exec_.stage("levels", [&] { choose_levels(plan_.octree); });
    const auto build = [&] { is_lbvh() ? build_hierarchy() : build_octree(plan_.octree); };
    if (needs().judges_resolution() && needs().settings.delta == 0)
      exec_.concurrently(build, [&] { octree_.count_small_triangles(); });
    else
      build();
    if (is_of_features(first_kind())) detect_features();
    if (needs().kinds.triangle_triangle) detect_triangles();
    narrow_.finish();
    if (needs().places_contacts()) exec_.stage("place", [&] { placing_.place(needs()); });
  }

  void build_octree(const OctreePlan& plan) {
    exec_.stage("count", [&] { octree_.count_overlapped_cells(plan); });
    if (plan.rounds > 0) exec_.stage("refine", [&] { octree_.refine(plan); });
    exec_.stage("bottom_up", [&] { octree_.cut(plan); });
    exec_.stage("top_down", [&] { octree_.place_leaves(plan); });
    exec_.stage("registration", [&] { octree_.register_triangles(plan); });
  }
  void build_hierarchy() {
    exec_.stage("sort", [&] { lbvh_.sort(); });
    exec_.stage("hierarchy", [&] { lbvh_.build(); });
  }

  void choose_levels(const OctreePlan& plan) {
    if (plan.engine == Engine::kLbvh)
      lbvh_.measure();
    else if (has_cells_of_triangles(plan.engine))
      octree_.choose_cells(plan);
    else
      octree_.choose_levels();
  }
  /// Whether the spacing of the positions' numbers, at the largest of them, is coarser than delta; without a delta,
  /// than a thousandth of most triangles.
  bool is_coarse() const {
    if (needs().settings.delta > 0) return spacing_at<Real>(state_.bounds) > needs().settings.delta;
    return 2 * state_.small_triangles > counts_.triangles - counts_.loose_points;
  }

  ContactKind first_kind() const { return first_of(needs().kinds); }
  /// use(kind) for the kinds of features that are wanted.
  template <class Use>
  void for_each_features(const Use& use) const {
    FeatureKinds::of(scene_.topology).for_each([&]<class Kind>(const Kind& kind) {
      if (value_of(needs().kinds, Kind::kKind)) use(kind);
    });
  }

  void detect_features() {
    if (needs().has_narrow_phase() && needs().is_any_hit()) return detect_in_turn();
    search(needs().kinds);
    if (needs().has_narrow_phase()) detect_side_by_side();
  }
  /// One kind may answer for all.
  void detect_in_turn() {
    for_each_features([&]<class Kind>(const Kind& kind) {
      PerKind<bool> alone;
      value_of(alone, Kind::kKind) = true;
      search(alone);
      narrow_.detect(kind);
    });
  }
  /// The first kind beside the others.
  void detect_side_by_side() {
    int kinds = 0;
    for_each_features([&](const auto&) { ++kinds; });
    const auto detect = [&](bool first) {
      for_each_features([&]<class Kind>(const Kind& kind) {
        if ((Kind::kKind == first_kind()) == first) narrow_.detect(kind);
      });
    };
    if (kinds == 1) return detect(true);
    exec_.concurrently([&] { detect(true); }, [&] { detect(false); });
  }

  /// 6.-8. Pairs, the boxes of the wanted features, and the filter of the level.
  void search(const PerKind<bool>& wanted) {
    exec_.stage("pairs", [&] {
      with_filter<Real>(needs(), needs().settings.reach(), scene_.state.data(),
                        [&](const auto& keep) { search_for(keep, wanted); });
    });
  }
  /// Scenes of triangles alone that leave nothing out and whose meshes keep to their paths have a search of their own,
  /// which does not ask.
  template <class Keep>
  void search_for(const Keep& keep, const PerKind<bool>& wanted) {
    // Rest pairs that rings leave out as well are kept, too: an edit may take the rings away.
    const ExcludedPairs excluded = needs().finds_rest_pairs ? ExcludedPairs{} : scene_.topology.excluded_pairs();
    const bool has_deviations = scene_.deviations(needs().is_ccd()).is_needed();
    if (excluded.is_needed() || has_deviations || counts_.has_loose_elements())
      search_for(keep, wanted, octree_.elementary_of_any(wanted), excluded);
    else
      search_for(keep, wanted, octree_.elementary(wanted), NothingExcluded{});
  }
  template <class Keep, class Tests, class Excluded>
  void search_for(const Keep& keep, const PerKind<bool>& wanted, const Tests& tests, const Excluded& excluded) {
    StepState* state = scene_.state.data();
    const bool is_narrow = needs().has_narrow_phase();
    const auto list = [&](ContactKind kind) { return is_narrow ? narrow_.kept(kind) : all_contacts(); };
    find_pairs("find_candidates", first_of(wanted),
               FeatureSink<Real, Keep, Tests, Excluded>{
                   tests,
                   keep,
                   list(ContactKind::kVertexTriangle),
                   list(ContactKind::kEdgeEdge),
                   is_narrow ? 0 : ranks_.begin[kIndexOf<EdgeEdge>],
                   narrow_.early_exit(),
                   {pairs_counter(first_of(wanted)), &state->candidates[kIndexOf<VertexTriangle>],
                    &state->candidates[kIndexOf<EdgeEdge>]},
                   excluded});
  }

  void detect_triangles() {
    constexpr ContactKind kKind = ContactKind::kTriangleTriangle;
    const bool is_narrow = needs().tests_triangles();
    exec_.stage("pairs_tt", [&] {
      const AppendList<uint64_t> pairs{scene_.triangle_pairs.all(), &scene_.state.data()->triangle_pairs};
      find_pairs("find_triangle_pairs", kKind,
                 TrianglePairSink{scene_.topology.triangles.all(),
                                  is_narrow ? pairs : all_contacts(),
                                  is_narrow ? 0 : ranks_.begin[index_of(kKind)],
                                  narrow_.early_exit(),
                                  {pairs_counter(kKind), nullptr, nullptr},
                                  scene_.topology.rings()});
    });
    if (is_narrow) narrow_.detect_triangles();
  }

  AppendList<uint64_t> all_contacts() const { return {scene_.contacts.keys.all(), &scene_.state.data()->contacts}; }
  /// Of a search that is for this kind first: the step's first search counts the pairs.
  uint64_t* pairs_counter(ContactKind first) const {
    return first == first_kind() ? &scene_.state.data()->pairs : nullptr;
  }
  template <class Sink>
  void find_pairs(const char* name, ContactKind first, const Sink& sink) {
    uint64_t* next_item = &scene_.state.data()->next_item[index_of(first)];
    is_lbvh() ? lbvh_.search(name, sink, next_item) : octree_.search(name, plan_.octree, sink, next_item);
  }

  OctreePlan plan_octree() const {
    const Engine engine = result_.broad_phase.engine;
    OctreePlan plan{engine, {cut_rule_of(engine), kRegistrationCost}};
    plan.levels = levels_.deepest + 1, plan.base = levels_.deepest;
    if (has_cells_of_triangles(engine))
      plan.levels = engine == Engine::kUniformGrid ? 1 : kLevelsOfCrowdedCell + 1;
    else if (levels_.base >= 0)
      plan.levels = levels_.base - levels_.top + 1, plan.base = levels_.base;
    plan.has_large = large_.is_expected() || !Exec::kLaunchesCost;
    if (engine != Engine::kOctree) return plan;
    plan.rounds = refinement_.rounds();
    plan.max_crowded_tests = refinement_.limit(counts_.triangles);
    return plan;
  }
  /// Counts of the step, and what follows from them for the next.
  void describe() {
    FrameCounts& c = result_.counts;
    const LeafTotals& leaves = state_.leaves;
    c.cells = leaves[LeafSum::kCells], c.leaves = leaves[LeafSum::kLeaves];
    c.registrations = leaves[LeafSum::kRegistrations], c.tests = leaves[LeafSum::kTests];
    c.top_level = static_cast<uint32_t>(state_.grid.grid.top);
    c.base_level = static_cast<uint32_t>(state_.grid.grid.base);
    c.pairs = state_.pairs;
    for_each_kind(
        [&](ContactKind kind, uint64_t& candidates, uint64_t& survivors) {
          if (!is_of_features(kind)) return;
          candidates = state_.candidates[index_of(kind)];
          if (needs().has_filter()) survivors = state_.kept[index_of(kind)];
        },
        c.candidates, c.survivors);
    const Engine engine = result_.broad_phase.engine;
    if (engine == Engine::kLbvh)
      lbvh_.describe(c);
    else if (!has_cells_of_triangles(engine))
      levels_ = next_levels({state_.grid.grid.top, state_.grid.grid.base, levels_.deepest}, leaves.level_registrations);
    result_.input_resolution = needs().judges_resolution() && is_coarse();
    result_.step_milliseconds = exec_.step_milliseconds();
    result_.graph_launches = exec_.graph_launches();
  }

  Exec& exec_;
  const SceneSpec& spec_;
  SceneCounts counts_;
  FeatureRanks ranks_;
  SceneBuffers<Exec, Real>& scene_;
  Searcher<Exec> searcher_;
  OctreePhase<Exec, Real> octree_;
  LbvhPhase<Exec, Real> lbvh_;
  NarrowPhase<Exec, Real> narrow_;
  Placing<Exec, Real> placing_;
  Results<Exec, Real> results_;
  EngineChoices choices_;
  Refinement refinement_;
  ActiveLevels levels_, sent_levels_{.deepest = -1};  ///< the latter are on the backend
  UsagePredictor large_;                              ///< triangles that cover many cells
  StepPlan plan_;                                     ///< of the last step
  std::optional<double> boxed_thickness_;             ///< that all boxes have
  PlanNumbers numbers_;
  StepState state_{};
  FrameResult result_;
};

}  // namespace collided
