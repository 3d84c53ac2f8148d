#pragma once
// The paper's Fig. 7 for one frame: positions that are resident in, contacts in canonical order out.
// enqueue() names the steps in their order; a scene runs those that its spec requires. The backend runs them without
// asking the host; lists that turn out too short are enlarged to the need and the step runs again.

#include <optional>
#include <utility>

#include "gpu/engines/engines.hpp"
#include "gpu/step/box_phase.hpp"
#include "gpu/step/contact_phase.hpp"
#include "gpu/step/cover_phase.hpp"
#include "gpu/step/neighbour_phase.hpp"
#include "gpu/step/placing.hpp"
#include "gpu/step/plan/step_planner.hpp"
#include "gpu/step/results.hpp"
#include "gpu/step/solid_results.hpp"
#include "gpu/step/step_run.hpp"

namespace collided {

template <Executor Exec, class Real>
class Pipeline {
 public:
  Pipeline(Exec& exec, const SceneSpec& spec, SceneCounts counts, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        spec_(spec),
        counts_(std::move(counts)),
        ranks_(ranks_of(kinds_looked_for(spec), counts_)),
        scene_(scene),
        searcher_(exec),
        context_{exec, searcher_, spec, counts_, scene},
        run_(exec, scene.state),
        boxes_(context_),
        engines_(context_),
        neighbours_(context_),
        narrow_(exec, ranks_, scene),
        candidates_(context_, boxes_, engines_, neighbours_, narrow_),
        contacts_(context_, run_, candidates_, narrow_),
        shorten_(context_),
        cover_(exec, scene),
        placing_(exec, scene),
        results_(exec, spec, scene, placing_),
        solids_(exec, spec, scene, results_),
        planner_(spec, planned_scene()) {
    narrow_.expect_loose_elements(counts_.has_loose_elements());
    scene_.expected = spec.expected;
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

  // Frames that advance.
  /// Measures all vertices' ways, of CCD. Waits.
  WaysMeasure measure_ways() {
    run_.begin();  // whoever is interrupted here has found nothing
    run_.reserve();
    shorten_.measure_ways();
    return run_.peek().ways;
  }
  /// Finds the frame's contacts, and the pairs that ways are shortened for, and judges these where all vertices go all
  /// of their ways. Not for pairs of triangles: they are those whose boxes meet, and boxes are wider.
  FrameResult detect_blocking(bool boxes_static, const FrameSettings& settings, uint64_t bytes_beside_contact,
                              const ContactRoom& room, const WayRules& ways) {
    scene_.share.send(exec_);
    LevelNeeds needs = needs_of(spec_, settings, room);
    needs.advances = true;
    needs.ways = ways;
    return detect(boxes_static, needs, bytes_beside_contact, room);
  }
  /// The same without contacts.
  FrameResult find_blocking(const WayRules& ways) {
    scene_.share.send(exec_);
    return detect(false, needs_of_ways(spec_, ways), 0, {});
  }
  /// Returns what the step has found, with the rounds that were run since.
  const StepState& found() const { return run_.found(); }
  void look_at_rounds() { run_.found() = run_.peek(); }
  /// Brings the pairs that have failed to the host as contacts, before the first round. `bytes_beside_contact`: as in
  /// FrameInput.
  PerKind<ContactSet> limits(uint64_t bytes_beside_contact) {
    const RoundCounts failed = found().round;
    if (failed.count_failed() == 0) return {};
    shorten_by_parts([&](ShortenPhase<Exec, Real>& shorten) {
      exec_.stage("advance", [&] { shorten.list_limits(failed.failed, ranks_, narrow_.id_counts()); });
    });
    return results_.limits(found().kinds, failed.count_failed(), bytes_beside_contact);
  }
  /// Runs rounds(shorten) as a step of its own, in one piece if it can. Rounds of one `kind` (below 256) put the same
  /// work in line, after steps of equal plans.
  template <class Rounds>
  void shorten(uint64_t kind, const Rounds& rounds) {
    constexpr uint64_t kOfRounds = uint64_t{1} << 63;  // no number of a plan
    const uint64_t number = kOfRounds | run_.number() << 8 | kind;
    if (!Exec::kRecordsLoops || exec_.allocations() > 0 || !exec_.can_step(number)) return shorten_by_parts(rounds);
    run_.found() = exec_.step(number, context_.state(), [&] { rounds(shorten_); });
  }
  /// The same, where the host has a part in it.
  template <class Rounds>
  void shorten_by_parts(const Rounds& rounds) {
    run_.found() = exec_.step_by_parts(context_.state(), [&] { rounds(shorten_); });
  }

  /// The scene is made of so much from the next step on. Throws InvalidInput where that is too much.
  void resize(SceneCounts counts) {
    ranks_ = ranks_of(kinds_looked_for(spec_), counts);
    counts_ = std::move(counts);
    planner_.resize(planned_scene());
    engines_.resize();
    narrow_.expect_loose_elements(counts_.has_loose_elements());
    boxed_.reset();
    numbers_.begin_anew();
  }
  /// Lists shrink to what they begin with.
  void release_lists() {
    static_cast<WorkBuffers<Exec, Real>&>(scene_) = WorkBuffers<Exec, Real>(exec_);
    scene_.expected = needed_ = {};
    engines_.release();
    neighbours_.release();
    searcher_.release();
    placing_.begin_anew();
    solids_.release();
    boxed_.reset();
    planner_.forget_lists();
  }

  /// Returns what a step that ended early had found; nothing if it had not begun to search.
  FrameProgress progress() {
    if (!run_.has_begun()) return {};
    const StepState found = run_.peek();
    FrameProgress progress{found.pairs, 0, found.contacts, {}};
    for (const uint64_t candidates : found.candidates) progress.candidates += candidates;
    return progress;
  }

  uint64_t answer_bytes() const { return results_.answer_bytes(); }
  /// What any step so far asked for.
  const ListLengths& list_lengths() const { return needed_; }

 private:
  /// Says how far boxes are grown.
  struct BoxWidth {
    double reach;
    bool counts_halves;  ///< those of thick meshes by more

    bool operator==(const BoxWidth&) const = default;
  };

  FrameResult detect(bool boxes_static, const LevelNeeds& needs, uint64_t bytes_beside_contact,
                     const ContactRoom& room) {
    const BoxWidth width{needs.reach(), needs.settings.differs_by_pair()};
    run_.begin();
    placing_.begin(room);
    const bool is_boxed = std::exchange(boxed_, std::nullopt) == width;
    planner_.begin(needs, found().bounds);
    const WorkTime time(exec_.asks());
    run_step(needs, boxes_static || !is_boxed || scene_.share.is_shard());
    const double work = time.milliseconds();
    boxed_ = width;
    contacts_.finish();
    needed_.include(lengths_of(found()));
    FrameResult result = describe();
    results_.collect(found(), needs, {bytes_beside_contact, room.first_on_host}, result);
    if (needs.looks_into_solids) solids_.look(needs, result);
    results_.place();
    if (needs.looks_into_solids) solids_.tell(result);
    result.stages = exec_.stage_times();
    result.allocations = exec_.allocations();
    // Steps by parts take longer than recorded ones.
    const bool is_clean = result.allocations == 0 && (!Exec::kLaunchesCost || !run_.is_by_parts());
    planner_.end(found(), work, is_clean, result);
    release_idle();
    return result;
  }

  /// Gives back the memory of whatever lost a comparison.
  void release_idle() {
    engines_.release_idle([&](Engine engine) { return planner_.is_idle(engine); });
    if (neighbours_.holds_memory() && planner_.are_lists_idle()) neighbours_.release(), planner_.forget_lists();
  }

  StepPlanner::Scene planned_scene() const {
    const ResidentTopology<Exec>& topology = scene_.topology;
    return {counts_.triangles, Exec::kLaunchesCost, topology.branches > 0, topology.idle.are_all};
  }
  const LevelNeeds& needs() const { return plan_.needs; }

  void run_step(const LevelNeeds& needs, bool boxes_static) {
    try {
      const AllowedWork allowed(exec_.asks(), planner_.longest_step());
      run_until_room(needs, boxes_static);
    } catch (const OutOfTime&) {
      if (planner_.uses_lists()) return planner_.give_up_lists(), run_without_lists(needs);
      planner_.abandon_engine();
      release_idle();
      run_until_room(needs, true);
    } catch (const ResourceExhausted&) {
      if (planner_.uses_lists()) return planner_.refuse_lists(), run_without_lists(needs);
      if (!planner_.retreat()) throw;
      release_idle();
      run_until_room(needs, boxes_static);
    } catch (...) {
      planner_.abandon_engine();
      throw;
    }
  }
  void run_without_lists(const LevelNeeds& needs) {
    neighbours_.release();
    run_step(needs, true);
  }
  /// Until everything the step found had room.
  void run_until_room(const LevelNeeds& needs, bool boxes_static) {
    run_.reserve();
    do {
      plan_ = planner_.plan(needs, boxes_static, narrow_.plan_order());
      engines_.plan(plan_);
      boxes_.begin(needs);
      contacts_.begin(needs);
      if (needs.advances) shorten_.begin(needs);
      begin_plan();
      run_.plan(numbers_.number_of(plan_));
      narrow_.follow(run_.is_by_parts() ? &found() : nullptr);
    } while (!run_.run([&] { enqueue(); }, [&] { return must_rerun(); }));
  }
  void begin_plan() {
    engines_.begin(plan_);
    narrow_.begin(plan_);
    candidates_.begin(plan_);
    reserve();
  }

  /// Of a whole step.
  bool must_rerun() {
    if (contacts_.has_hit()) return false;
    const bool missed = must_search(), lists_grew = must_list_anew(), narrow_grew = narrow_.grow(found(), 0),
               reorders = narrow_.reorders(found());
    return missed || must_plan_anew(lists_grew || narrow_grew || reorders);
  }
  /// Of the part that runs the engine's stages, or looks at what lists are still good for.
  bool must_rebuild() {
    if (!must_search() && !must_plan_anew(false)) return false;
    plan_.lists = planner_.lists();
    engines_.plan(plan_);
    engines_.begin(plan_);
    candidates_.begin(plan_);
    reserve();
    return true;
  }
  /// The lists do not hold all that may touch.
  bool must_search() {
    if (plan_.searches() || found().displacement.slack >= 0) return false;
    planner_.miss(found().displacement);
    return true;
  }
  /// The engine's lists, or whatever else was too short.
  bool must_plan_anew(bool others_grew) {
    if (!plan_.has_engine()) return others_grew;
    return engines_.grow(found()) || others_grew || engines_.must_refine(found());
  }
  /// Of the part that lists neighbours.
  bool must_list_anew() {
    if (!plan_.makes_lists()) return false;
    if (neighbours_.are_too_long(found())) throw ResourceExhausted("lists of neighbours are too long to be of use");
    return neighbours_.grow(found());
  }

  /// Where there is no room for what is expected, lists begin as they do without.
  void reserve() {
    try {
      reserve_lists();
    } catch (...) {
      if (!scene_.expected.is_known()) throw;
      scene_.expect_nothing(exec_);
      engines_.release();
      reserve_lists();
    }
  }
  void reserve_lists() {
    scene_.reserve_boxes(counts_.triangles, counts_.vertices);
    narrow_.reserve();
    if (needs().tells_features) cover_.reserve();
    if (needs().advances) shorten_.reserve();
    if (planner_.uses_lists()) neighbours_.reserve(times_ = planner_.track_times());
    if (plan_.has_engine()) engines_.reserve();
  }

  /// Fig. 7.
  void enqueue() {
    run_.part([&] { plan_.searches() ? search_anew() : look_for_displacement(); }, [&] { return must_rebuild(); });
    run_.mark_begun();
    if (plan_.makes_lists()) list_neighbours();
    if (needs().advances) shorten_.begin_ways();
    if (!plan_.is_idle && needs().kinds != PerKind<bool>{})
      needs().advances ? contacts_.detect_blocking(shorten_) : contacts_.detect_all();
    if (!needs().tells_contacts) return;
    if (needs().is_earliest_only()) contacts_.keep_earliest();
    if (run_.is_by_parts()) plan_order();
    narrow_.finish();
    if (needs().tells_features) exec_.stage("cover", [&] { cover_.run(needs()); });
    if (needs().places_contacts()) exec_.stage("place", [&] { placing_.place(needs()); });
  }
  /// How many contacts there are is known.
  void plan_order() {
    narrow_.reorders(found());
    plan_.order = narrow_.plan_order();
    narrow_.begin(plan_);
    narrow_.reserve();
    if (needs().tells_features) cover_.reserve();
  }

  /// Boxes, and the stages of the engine. With lists to be made: of all that vertices will pass through.
  void search_anew() {
    const bool is_for_lists = plan_.makes_lists();
    exec_.stage(is_for_lists ? "widened_boxes" : "boxes", [&] {
      if (is_for_lists) boxes_.widen(plan_.lists.margin, neighbours_.extrapolate(plan_.lists.frames, needs().is_ccd()));
      exec_.concurrently([&] { boxes_.box_triangles(plan_.boxes_static || is_for_lists); }, [&] { clear(); });
    });
    exec_.stage("levels", [&] { plan_.is_idle ? context_.measure_bounds_alone(needs()) : engines_.measure(); });
    if (judges_triangles() && !is_for_lists)
      exec_.concurrently([&] { build(); }, [&] { boxes_.count_small_triangles(); });
    else
      build();
  }
  void clear() {
    exec_.fill_zero(context_.state(), sizeof(StepState));
    if (plan_.has_engine()) engines_.clear();
  }
  void build() {
    if (!plan_.is_idle) engines_.build();
  }
  bool judges_triangles() const { return needs().judges_resolution() && needs().settings.delta == 0; }
  void list_neighbours() {
    run_.part([&] { candidates_.search_neighbours(); }, [&] { return must_list_anew(); });
    boxes_.narrow();
    exec_.stage("boxes", [&] {
      boxes_.box_triangles(true);
      neighbours_.begin_tracks(boxes_.elementary_of_any(needs().kinds));
    });
    measure_displacement();
  }
  void look_for_displacement() {
    exec_.stage("boxes",
                [&] { exec_.concurrently([&] { boxes_.box_triangles(plan_.boxes_static); }, [&] { clear(); }); });
    measure_displacement();
  }
  void measure_displacement() {
    exec_.stage("displacement", [&] {
      neighbours_.measure(boxes_.elementary_of_any(needs().kinds), needs());
      if (judges_triangles()) boxes_.count_small_triangles();
    });
  }

  /// Counts of the step, and what follows from them for the next.
  FrameResult describe() {
    FrameResult result;
    FrameCounts& c = result.counts = counts_of(found(), needs());
    if (!plan_.has_engine()) c.top_level = c.base_level = 0;
    if (!plan_.searches()) c.tests = planner_.listed_tests();
    if (plan_.has_engine()) engines_.finish(found(), c);
    result.broad_phase = planner_.engine();
    result.input_resolution = needs().judges_resolution() && boxes_.is_coarse(found());
    result.step_milliseconds = exec_.step_milliseconds();
    result.graph_launches = exec_.graph_launches();
    result.replays = static_cast<uint32_t>(run_.replays());
    return result;
  }

  Exec& exec_;
  const SceneSpec& spec_;
  SceneCounts counts_;
  FeatureRanks ranks_;
  SceneBuffers<Exec, Real>& scene_;
  Searcher<Exec> searcher_;
  StepContext<Exec, Real> context_;
  StepRun<Exec> run_;
  BoxPhase<Exec, Real> boxes_;
  Engines<Exec, Real> engines_;
  NeighbourPhase<Exec, Real> neighbours_;
  NarrowPhase<Exec, Real> narrow_;
  CandidatePhase<Exec, Real> candidates_;
  ContactPhase<Exec, Real> contacts_;
  ShortenPhase<Exec, Real> shorten_;
  CoverPhase<Exec, Real> cover_;
  Placing<Exec, Real> placing_;
  Results<Exec, Real> results_;
  SolidResults<Exec, Real> solids_;
  StepPlanner planner_;
  PlanNumbers numbers_;
  StepPlan plan_;                  ///< of the last step
  TrackTimes times_{};             ///< of the step in work
  std::optional<BoxWidth> boxed_;  ///< of all boxes
  ListLengths needed_;
};

}  // namespace collided
