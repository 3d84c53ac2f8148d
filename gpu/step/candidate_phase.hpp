#pragma once
// Steps 6 to 8 of Fig. 7: the pairs that the frame's engine finds go to the sinks that make candidates of them.

#include "gpu/engines/engines.hpp"
#include "gpu/step/box_phase.hpp"
#include "gpu/step/narrow_phase.hpp"
#include "gpu/step/neighbour_phase.hpp"
#include "gpu/step/sinks.hpp"

namespace collided {

template <Executor Exec, class Real>
class CandidatePhase {
 public:
  CandidatePhase(const StepContext<Exec, Real>& context, const BoxPhase<Exec, Real>& boxes,
                 Engines<Exec, Real>& engines, NeighbourPhase<Exec, Real>& neighbours, NarrowPhase<Exec, Real>& narrow)
      : exec_(context.exec),
        counts_(context.counts),
        scene_(context.scene),
        boxes_(boxes),
        engines_(engines),
        neighbours_(neighbours),
        narrow_(narrow) {}

  /// What the next searches are for.
  void begin(const StepPlan& plan) { plan_ = plan; }

  /// 6.-8. Pairs, the boxes of the wanted features, and the filter of the level.
  void search(const PerKind<bool>& wanted) {
    exec_.stage("pairs", [&] {
      with_filter<Real>(
          needs(), needs().settings.reach(), scene_.state.data(), [&](const auto& keep) { search_for(keep, wanted); },
          filters_of_worlds());
    });
  }
  /// 6.-7. Pairs, and the widened boxes of their features, for the lists of neighbours.
  void search_neighbours() {
    exec_.stage("neighbours", [&] {
      if (is_plain())
        list_neighbours(boxes_.elementary(needs().kinds));
      else
        list_neighbours(boxes_.elementary_of_any(needs().kinds));
      neighbours_.keep_counts();
    });
  }
  /// Pairs of triangles, which are contacts where nothing looks at them more closely.
  void search_triangles() {
    constexpr ContactKind kKind = ContactKind::kTriangleTriangle;
    exec_.stage("pairs_tt", [&] { find_pairs("find_triangle_pairs", kKind, sink_of_triangles(kKind)); });
  }
  /// Pairs of triangles an edge of which may go through the other.
  void search_crossings() {
    constexpr ContactKind kKind = ContactKind::kEdgeTriangle;
    exec_.stage("pairs_et",
                [&] { find_pairs("find_crossing_pairs", kKind, CrossingPairSink{sink_of_triangles(kKind)}); });
  }

 private:
  const LevelNeeds& needs() const { return plan_.needs; }
  ContactKind first_kind() const { return first_of(needs().kinds); }

  /// Scenes of triangles alone that leave nothing out, and whose meshes keep to their paths and are not thick by
  /// themselves, have a search of their own, which does not ask.
  template <class Keep>
  void search_for(const Keep& keep, const PerKind<bool>& wanted) {
    // Rest pairs that rings leave out as well are kept, too: an edit may take the rings away.
    const ExcludedPairs excluded = needs().finds_rest_pairs ? ExcludedPairs{} : scene_.topology.excluded_pairs();
    if (excluded.is_needed() || !is_plain())
      search_for(keep, wanted, boxes_.elementary_of_any(wanted), excluded);
    else
      search_for(keep, wanted, boxes_.elementary(wanted), NothingExcluded{});
  }
  bool is_plain() const {
    return !scene_.deviations(needs().is_ccd()).is_needed() && !needs().settings.differs_by_pair() &&
           !counts_.has_loose_elements();
  }
  template <class Keep, class Tests, class Excluded>
  void search_for(const Keep& keep, const PerKind<bool>& wanted, const Tests& tests, const Excluded& excluded) {
    StepState* state = scene_.state.data();
    const bool is_narrow = needs().has_narrow_phase();
    const auto list = [&](ContactKind kind) { return is_narrow ? narrow_.kept(kind) : all_contacts(); };
    find("find_candidates", first_of(wanted),
         FeatureSink<Real, Keep, Tests, Excluded>{
             tests,
             keep,
             list(ContactKind::kVertexTriangle),
             list(ContactKind::kEdgeEdge),
             is_narrow ? 0 : narrow_.ranks().begin[kIndexOf<EdgeEdge>],
             narrow_.early_exit(first_of(wanted)),
             {pairs_counter(first_of(wanted)), &state->candidates[kIndexOf<VertexTriangle>],
              &state->candidates[kIndexOf<EdgeEdge>]},
             excluded});
  }

  template <class Tests>
  void list_neighbours(const Tests& tests) {
    const FrameSettings& settings = needs().settings;
    const MayTouchSoon<Real> may_touch{settings.reach_of_any_pair(), scene_.deviations(needs().is_ccd()),
                                       settings.delta, plan_.lists.margin, plan_.lists.frames + 1};
    find_pairs("find_neighbours", first_kind(),
               NeighbourSink<Real, Tests>{{tests,
                                           may_touch,
                                           neighbours_.list(0),
                                           neighbours_.list(1),
                                           0,
                                           {},
                                           {pairs_counter(first_kind()), nullptr, nullptr}}});
  }

  TrianglePairSink sink_of_triangles(ContactKind kind) const {
    const bool is_narrow = needs().tests(kind);
    return {scene_.topology.corners(),
            is_narrow ? narrow_.pairs_of_triangles(kind) : all_contacts(),
            is_narrow ? 0 : narrow_.ranks().begin[index_of(kind)],
            narrow_.early_exit(kind),
            {pairs_counter(kind), nullptr, nullptr},
            scene_.topology.rings(),
            is_narrow ? 1 : 0};  // boxes say nothing of neighbours: they always overlap
  }
  FiltersOfWorlds filters_of_worlds() const {
    return counts_.worlds == 0 ? FiltersOfWorlds{}
                               : FiltersOfWorlds{scene_.worlds.filters.data(), counts_.world_shape().triangles};
  }
  AppendList<uint64_t> all_contacts() const { return {scene_.contacts.keys.all(), &scene_.state.data()->contacts}; }
  /// Of a search that is for this kind first: the step's first search counts the pairs.
  uint64_t* pairs_counter(ContactKind first) const {
    return first == first_kind() ? &scene_.state.data()->pairs : nullptr;
  }
  /// By a search, or among the neighbours.
  template <class Sink>
  void find(const char* name, ContactKind first, const Sink& sink) {
    if (plan_.lists.use == ListUse::kNone) return find_pairs(name, first, sink);
    neighbours_.test(name, sink);
  }
  template <class Sink>
  void find_pairs(const char* name, ContactKind first, const Sink& sink) {
    uint64_t* next_item = &scene_.state.data()->next_item[index_of(first)];
    engines_.search(name, sink, next_item, first == first_kind());
  }

  Exec& exec_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
  const BoxPhase<Exec, Real>& boxes_;
  Engines<Exec, Real>& engines_;
  NeighbourPhase<Exec, Real>& neighbours_;
  NarrowPhase<Exec, Real>& narrow_;
  StepPlan plan_;
};

}  // namespace collided
