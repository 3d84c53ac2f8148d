#pragma once
// The paper's Fig. 7 for one frame: positions that are resident in, contacts in canonical order out.
// enqueue() names the steps in their order; a scene runs those that its spec requires. The backend runs them without
// asking the host; lists that turn out too short are enlarged to the need and the step runs again.

#include <optional>
#include <utility>

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/step/advance.hpp"
#include "gpu/step/candidate_phase.hpp"
#include "gpu/step/lbvh_phase.hpp"
#include "gpu/step/narrow_phase.hpp"
#include "gpu/step/octree_phase.hpp"
#include "gpu/step/placing.hpp"
#include "gpu/step/plan/engine_choices.hpp"
#include "gpu/step/plan/octree_planner.hpp"
#include "gpu/step/plan/plan.hpp"
#include "gpu/step/plan/reuse_planner.hpp"
#include "gpu/step/results.hpp"

namespace collided {

template <Executor Exec, class Real>
class Pipeline {
 public:
  Pipeline(Exec& exec, const SceneSpec& spec, SceneCounts counts, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        spec_(spec),
        counts_(std::move(counts)),
        ranks_(ranks_of(spec.kinds, counts_)),
        scene_(scene),
        searcher_(exec),
        octree_(exec, searcher_, spec, counts_, scene),
        lbvh_(exec, searcher_, counts_, scene),
        all_pairs_(exec, searcher_, counts_, scene),
        neighbours_(exec, searcher_, counts_, scene),
        narrow_(exec, ranks_, scene),
        candidates_(exec, counts_, ranks_, scene, octree_, lbvh_, all_pairs_, neighbours_, narrow_),
        placing_(exec, scene),
        results_(exec, spec, scene, placing_),
        choices_(engine_of(spec), rivals()),
        reuse_(spec),
        planner_(counts_.triangles) {
    narrow_.expect_loose_elements(counts_.has_loose_elements());
    scene_.expected = spec.expected;
    suit_reuse();
  }

  /// `boxes_static`: the boxes of static meshes too are out of date. `bytes_beside_contact`, `room`: as in FrameInput.
  FrameResult detect_contacts(bool boxes_static, const FrameSettings& settings, uint64_t bytes_beside_contact,
                              const ContactRoom& room = {}) {
    scene_.share.send(exec_);
    return detect(boxes_static, needs_of(spec_, settings, room), bytes_beside_contact, room);
  }
  /// The pairs that `needs_of_rest_pairs` says, as contacts; all of them in every part of a scene.
  FrameResult detect_rest_pairs() {
    scene_.share.send_all(exec_);
    return detect(true, needs_of_rest_pairs(spec_), 0, {});
  }

  /// Bounds of all vertices' ways in the step that comes, which is one of CCD, rounded outward. Waits.
  Box<float> measure_way() {
    begin_state();
    StepState* state = scene_.state.data();
    exec_.reduce_into("bounds", counts_.vertices, BoxOfWay<Real>{scene_.positions_at_start(true), scene_.end.data()},
                      empty_box(), JoinBoxes{}, &state->bounds);
    return exec_.peek(state).bounds;
  }

  /// The scene is made of so much from the next step on. Throws InvalidInput where that is too much.
  void resize(SceneCounts counts) {
    ranks_ = ranks_of(spec_.kinds, counts);
    counts_ = std::move(counts);
    choices_.choose_between(rivals());
    suit_reuse();
    planner_.resize(counts_.triangles);
    narrow_.expect_loose_elements(counts_.has_loose_elements());
    boxed_thickness_.reset();
    reuse_.forget();
    numbers_.begin_anew();
  }
  /// Lists shrink to what they begin with.
  void release_lists() {
    static_cast<WorkBuffers<Exec, Real>&>(scene_) = WorkBuffers<Exec, Real>(exec_);
    scene_.expected = needed_ = {};
    searcher_.release();
    placing_.begin_anew();
    sent_levels_ = {.deepest = -1};
    boxed_thickness_.reset();
    reuse_.forget();
  }

  /// Returns what a step that ended early had found; nothing if it had not begun to search.
  FrameProgress progress() {
    if (!has_begun_) return {};
    const StepState found = exec_.peek(scene_.state.data());
    FrameProgress progress{found.pairs, 0, found.contacts, {}};
    for (const uint64_t candidates : found.candidates) progress.candidates += candidates;
    return progress;
  }

  uint64_t answer_bytes() const { return results_.answer_bytes(); }
  /// What any step so far asked for.
  const ListLengths& list_lengths() const { return needed_; }

 private:
  FrameResult detect(bool boxes_static, const LevelNeeds& needs, uint64_t bytes_beside_contact,
                     const ContactRoom& room) {
    const double thickness = needs.settings.reach();
    result_ = {};
    has_begun_ = false;
    placing_.begin(room);
    const bool is_boxed = std::exchange(boxed_thickness_, std::nullopt) == thickness;
    lists_ = reuse_.begin(needs, state_.bounds);
    result_.broad_phase = choices_.begin(needs, lists_.use == ListUse::kNone && !is_idle());
    const WorkTime time(exec_.asks());
    run_step(needs, boxes_static || !is_boxed || scene_.share.is_part());
    const double work = time.milliseconds();
    boxed_thickness_ = thickness;
    if (needs.is_any_hit()) had_hit_ = has_hit();
    needed_.include(lengths_of(state_));
    describe();
    results_.collect(state_, needs, {bytes_beside_contact, room.first_on_host}, result_);
    result_.stages = exec_.stage_times();
    result_.allocations = exec_.allocations();
    // Steps by parts take longer than recorded ones.
    const bool is_clean = result_.allocations == 0 && (!Exec::kLaunchesCost || !by_parts_);
    choices_.end(result_, state_.totals.boxed(), state_.bricks[0] > 0, is_clean && result_.replays == 0);
    reuse_.end(lists_, state_.displacement, state_.neighbours[0] + state_.neighbours[1], result_.step_milliseconds,
               work, is_clean);
    result_.reuse = reuse_.facts(lists_);
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
    if (scene_.all_pairs.triangles > 0 && choices_.is_idle(Engine::kAllPairs))
      scene_.all_pairs = AllPairsBuffers<Exec>(exec_);
    if (scene_.neighbours.counts.capacity() > 0 && reuse_.is_idle()) neighbours_.release(), reuse_.forget();
  }

  Rivals rivals() const {
    return rivals_of(counts_.triangles, Exec::kLaunchesCost, scene_.topology.branches > 0);
  }
  /// True if no two meshes may touch and the step makes no lists.
  bool is_idle() const { return scene_.topology.idle.are_all && lists_.use == ListUse::kNone; }
  void suit_reuse() {
    reuse_.suit(!scene_.topology.idle.are_all && !is_launch_bound(counts_.triangles, Exec::kLaunchesCost));
  }
  const LevelNeeds& needs() const { return plan_.needs; }

  void run_step(const LevelNeeds& needs, bool boxes_static) {
    try {
      const bool has_lists = lists_.use != ListUse::kNone;
      const AllowedWork allowed(exec_.asks(), has_lists ? reuse_.longest_step(lists_) : choices_.longest_step());
      run_until_room(needs, boxes_static);
    } catch (const OutOfTime&) {
      if (lists_.use != ListUse::kNone) return reuse_.give_up(), run_without_lists(needs);
      result_.broad_phase = choices_.abandon();
      release_idle_engines();
      run_until_room(needs, true);
    } catch (const ResourceExhausted&) {
      if (lists_.use != ListUse::kNone) return reuse_.refuse(), run_without_lists(needs);
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
  void run_without_lists(const LevelNeeds& needs) {
    neighbours_.release(), lists_ = {};
    run_step(needs, true);
  }
  /// Until everything the step found had room. A step that will not be as it is again, because memory was allocated for
  /// it, runs by parts: where it was short of room only the last part runs again. So does one that would have to wait
  /// for recordings of others. On CPU cores all do.
  void run_until_room(const LevelNeeds& needs, bool boxes_static) {
    begin_state();
    for (;;) {
      plan_ = {needs, plan_octree(), boxes_static, narrow_.plan_order(), lists_, is_idle()};
      octree_.begin(needs.settings.reach(), needs.is_ccd());
      lbvh_.begin(needs.settings.reach(), needs.is_ccd());
      all_pairs_.begin(needs.settings.reach(), needs.is_ccd());
      narrow_.begin(plan_);
      candidates_.begin(plan_);
      reserve();
      const uint64_t number = numbers_.number_of(plan_);
      by_parts_ = !Exec::kLaunchesCost || exec_.allocations() > 0 || !exec_.can_step(number);
      narrow_.follow(by_parts_ ? &state_ : nullptr);
      if (by_parts_) {
        state_ = exec_.step_by_parts(scene_.state.data(), [&] { enqueue(); });
        return;
      }
      has_begun_ = true;
      state_ = exec_.step(number, scene_.state.data(), [&] { enqueue(); });
      if (!must_rerun()) return;
      ++result_.replays;
    }
  }
  /// The second is what the first was before a part, the third what it was before a search at kAnyHit.
  void begin_state() {
    constexpr uint64_t kStates = 3;
    if (scene_.state.capacity() > 0) return;
    scene_.state.allocate(kStates);
    exec_.fill_zero(scene_.state.data(), kStates * sizeof(StepState));
  }

  /// Part of a step. After it, where steps run by parts, `must_rerun` makes room for what it asked for.
  template <class Put, class MustRerun>
  void part(const Put& put, const MustRerun& must_rerun) {
    if (!by_parts_) return put();
    StepState* state = scene_.state.data();
    exec_.copy(state + 1, state, sizeof(StepState));
    for (;;) {
      put();
      state_ = exec_.peek(state);
      if (!must_rerun()) return;
      ++result_.replays;
      exec_.copy(state, state + 1, sizeof(StepState));
    }
  }
  template <class Put>
  void part(const Put& put) {
    const uint64_t contacts_before = state_.contacts;
    part(put, [&] { return narrow_.grow(state_, contacts_before); });
  }

  /// Of a whole step.
  bool must_rerun() {
    if (has_hit()) return false;
    const bool missed = must_search(), lists_grew = must_list_anew(), narrow_grew = narrow_.grow(state_, 0),
               reorders = narrow_.reorders(state_);
    return missed || must_plan_anew(lists_grew || narrow_grew || reorders);
  }
  /// Of the part that makes the octree, or the hierarchy, or looks at what lists are still good for.
  bool must_rebuild() {
    if (!must_search() && !must_plan_anew(false)) return false;
    plan_.octree = plan_octree();
    plan_.lists = lists_;
    candidates_.begin(plan_);
    reserve();
    return true;
  }
  /// The lists do not hold all that may touch.
  bool must_search() {
    if (plan_.searches() || state_.displacement.slack >= 0) return false;
    lists_ = reuse_.miss(state_.displacement);
    return true;
  }
  /// The octree, or whatever else was too short.
  bool must_plan_anew(bool others_grew) {
    if (!plan_.searches() || plan_.is_idle) return others_grew;
    const bool grew = octree_.grow(state_), missed_large = planner_.missed_large(state_, plan_.octree);
    return grew || others_grew || missed_large || planner_.needs_refinement(state_, plan_.octree);
  }
  /// Of the part that lists neighbours.
  bool must_list_anew() {
    if (plan_.lists.use != ListUse::kMade) return false;
    if (neighbours_.are_too_long(state_)) throw ResourceExhausted("lists of neighbours are too long to be of use");
    return neighbours_.grow(state_);
  }
  OctreePlan plan_octree() const {
    return planner_.plan(result_.broad_phase.engine, !Exec::kLaunchesCost, makes_lists());
  }
  bool makes_lists() const { return lists_.use == ListUse::kMade; }

  /// Where there is no room for what is expected, lists begin as they do without.
  void reserve() {
    try {
      reserve_lists();
    } catch (...) {
      if (!scene_.expected.is_known()) throw;
      scene_.expect_nothing(exec_);
      sent_levels_ = {.deepest = -1};
      reserve_lists();
    }
  }
  void reserve_lists() {
    scene_.reserve_boxes(counts_.triangles, counts_.vertices);
    narrow_.reserve();
    if (plan_.lists.use != ListUse::kNone) neighbours_.reserve(times_ = reuse_.times(plan_.lists));
    if (!plan_.searches() || plan_.is_idle) return;
    if (engine() == Engine::kLbvh) return lbvh_.reserve();
    if (engine() == Engine::kAllPairs) return all_pairs_.reserve();
    octree_.reserve(plan_.octree);
    const ActiveLevels& levels = planner_.levels(makes_lists());
    if (std::exchange(sent_levels_, levels) == levels) return;
    exec_.upload(scene_.octree.wanted.data(), &sent_levels_, sizeof(sent_levels_));
  }
  /// That searches, where the step does.
  Engine engine() const { return plan_.octree.engine; }

  /// Fig. 7.
  void enqueue() {
    part([&] { plan_.searches() ? make_tree() : look_for_displacement(); }, [&] { return must_rebuild(); });
    has_begun_ = true;
    if (plan_.lists.use == ListUse::kMade) list_neighbours();
    if (!plan_.is_idle) detect_all();
    if (needs().is_earliest_only()) part([&] { narrow_.keep_earliest(); });
    if (by_parts_) plan_order();
    narrow_.finish();
    if (needs().places_contacts()) exec_.stage("place", [&] { placing_.place(needs()); });
  }
  void detect_all() {
    if (is_of_features(first_kind())) detect_features();
    if (needs().kinds.triangle_triangle) detect_triangles();
  }
  /// How many contacts there are is known.
  void plan_order() {
    narrow_.reorders(state_);
    plan_.order = narrow_.plan_order();
    narrow_.begin(plan_);
    narrow_.reserve();
  }

  /// With lists to be made: of all that vertices will pass through.
  void make_tree() {
    const bool is_for_lists = plan_.lists.use == ListUse::kMade;
    exec_.stage(is_for_lists ? "widened_boxes" : "boxes", [&] {
      if (is_for_lists)
        octree_.widen(plan_.lists.margin, neighbours_.extrapolate(plan_.lists.frames, needs().is_ccd()));
      exec_.concurrently([&] { octree_.box_triangles(plan_.boxes_static || is_for_lists); },
                         [&] { plan_.is_idle ? octree_.clear_state() : octree_.clear(plan_.octree); });
    });
    exec_.stage("levels", [&] { measure(); });
    if (judges_triangles() && !is_for_lists)
      exec_.concurrently([&] { build(); }, [&] { octree_.count_small_triangles(); });
    else
      build();
  }
  bool judges_triangles() const { return needs().judges_resolution() && needs().settings.delta == 0; }
  void list_neighbours() {
    part([&] { candidates_.search_neighbours(); }, [&] { return must_list_anew(); });
    octree_.narrow();
    exec_.stage("boxes", [&] {
      octree_.box_triangles(true);
      neighbours_.begin_tracks(octree_.elementary_of_any(needs().kinds));
    });
    measure_displacement();
  }
  void look_for_displacement() {
    exec_.stage("boxes", [&] {
      exec_.concurrently([&] { octree_.box_triangles(plan_.boxes_static); }, [&] { octree_.clear_state(); });
    });
    measure_displacement();
  }
  void measure_displacement() {
    exec_.stage("displacement", [&] {
      neighbours_.measure(octree_.elementary_of_any(needs().kinds), needs().settings.reach(), needs().is_ccd());
      if (judges_triangles()) octree_.count_small_triangles();
    });
  }
  /// How large the scene is, and what follows from that.
  void measure() {
    if (plan_.is_idle) return all_pairs_.measure();
    switch (engine()) {
      case Engine::kLbvh:
        return lbvh_.measure();
      case Engine::kAllPairs:
        return all_pairs_.measure();
      default:
        octree_.choose_grid(plan_.octree);
    }
  }
  void build() {
    if (plan_.is_idle) return;
    if (engine() == Engine::kLbvh) lbvh_.build();
    if (plan_.octree.has_octree()) octree_.build(plan_.octree);
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
    part([&] { candidates_.search(needs().kinds); });
    if (needs().has_narrow_phase()) detect_side_by_side();
  }
  template <class Kind>
  void detect(const Kind& kind) {
    narrow_.detect(kind, [&](const auto& put) { part(put); });
  }
  /// One kind may answer for all.
  void detect_in_turn() {
    for_each_features([&]<class Kind>(const Kind& kind) {
      PerKind<bool> alone;
      value_of(alone, Kind::kKind) = true;
      look_for_hit(
          Kind::kKind, [&] { candidates_.search(alone); }, [&] { detect(kind); });
    });
  }
  bool has_hit() const { return needs().is_any_hit() && state_.shortcut.has_contact != 0; }
  /// Tests the first candidates before the search makes more: bodies in one place make millions, and the first tells.
  /// After that, the candidates that the list has room for are tested before the list grows.
  template <class Search, class Detect>
  void look_for_hit(ContactKind kind, const Search& search, const Detect& detect) {
    if (!by_parts_) return search(), detect();
    if (has_hit()) return;
    StepState* state = scene_.state.data();
    exec_.copy(state + 2, state, sizeof(StepState));
    constexpr uint64_t kFirst = 4096;
    for (uint64_t most = had_hit_ ? kFirst : narrow_.kAll;; most = narrow_.kAll, ++result_.replays) {
      narrow_.look_at_first(most);
      part(search, [] { return false; });
      const uint64_t found = narrow_.cut_off(kind, state_);
      detect();
      if (found == 0 || has_hit()) break;
      narrow_.make_room(kind, found);
      exec_.copy(state, state + 2, sizeof(StepState));
    }
    narrow_.look_at_first(narrow_.kAll);
  }
  /// The first kind beside the others.
  void detect_side_by_side() {
    int kinds = 0;
    for_each_features([&](const auto&) { ++kinds; });
    const auto detect = [&](bool first) {
      for_each_features([&]<class Kind>(const Kind& kind) {
        if ((Kind::kKind == first_kind()) == first) this->detect(kind);
      });
    };
    if (kinds == 1) return detect(true);
    exec_.concurrently([&] { detect(true); }, [&] { detect(false); });
  }

  void detect_triangles() {
    const auto search = [&] { candidates_.search_triangles(); };
    const auto detect = [&] { part([&] { narrow_.detect_triangles(); }); };
    if (needs().is_any_hit()) return look_for_hit(ContactKind::kTriangleTriangle, search, detect);
    part(search);
    if (needs().tests_triangles()) detect();
  }

  /// Counts of the step, and what follows from them for the next.
  void describe() {
    FrameCounts& c = result_.counts = counts_of(state_, needs());
    if (!plan_.searches())
      c.tests = reuse_.length(), c.top_level = c.base_level = 0;
    else if (plan_.is_idle)
      c.top_level = c.base_level = 0;
    else if (engine() == Engine::kLbvh)
      lbvh_.describe(c);
    else if (engine() == Engine::kAllPairs)
      all_pairs_.describe(c);
    else if (!has_cells_of_triangles(engine()))
      planner_.learn_levels(state_, makes_lists());
    result_.input_resolution = needs().judges_resolution() && octree_.is_coarse(state_, needs().settings);
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
  AllPairsPhase<Exec, Real> all_pairs_;
  NeighbourPhase<Exec, Real> neighbours_;
  NarrowPhase<Exec, Real> narrow_;
  CandidatePhase<Exec, Real> candidates_;
  Placing<Exec, Real> placing_;
  Results<Exec, Real> results_;
  EngineChoices choices_;
  ReusePlanner reuse_;
  OctreePlanner planner_;
  ActiveLevels sent_levels_{.deepest = -1};  ///< that are on the backend
  bool by_parts_ = false;                    ///< the step in work
  bool has_begun_ = false;                   ///< likewise: its counters are its own
  bool had_hit_ = true;                      ///< the last step at kAnyHit; as good as a guess before the first
  StepPlan plan_;                            ///< of the last step
  ListPlan lists_;                           ///< of the step in work
  TrackTimes times_{};                       ///< likewise
  std::optional<double> boxed_thickness_;    ///< that all boxes have
  PlanNumbers numbers_;
  StepState state_{};
  ListLengths needed_;
  FrameResult result_;
};

}  // namespace collided
