#pragma once
// From the candidates that the filter kept to contacts, at the frame's accuracy level (step 8 of Fig. 7). Everything is
// put in line for the backend; no length is read back.

#include <utility>

#include "gpu/narrow/certified_proximity.hpp"
#include "gpu/narrow/fast_loose.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/narrow/normal.hpp"
#include "gpu/narrow/proximity.hpp"
#include "gpu/narrow/triangle_pairs.hpp"
#include "gpu/state/buffers.hpp"
#include "gpu/state/plan.hpp"
#include "gpu/step/crossing_pairs.hpp"
#include "gpu/step/deciding.hpp"
#include "gpu/step/plan/order_predictor.hpp"

#ifndef __CUDACC__
#include "gpu/narrow/cpu/approach.hpp"
#include "gpu/narrow/cpu/screen.hpp"
#endif

namespace collided {

template <Executor Exec, class Real>
class NarrowPhase {
 public:
  NarrowPhase(Exec& exec, const FeatureRanks& ranks, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), ranks_(ranks), scene_(scene) {}

  const FeatureRanks& ranks() const { return ranks_; }
  /// Second features are triangles, or of the same kind as the first.
  IdCounts id_counts() const {
    return {ranks_.count(), max(uint64_t{ranks_.most_of_a_kind()}, scene_.topology.triangle_count())};
  }
  /// Whether some elements of the scene are no triangles.
  void expect_loose_elements(bool are_there) { has_loose_elements_ = are_there; }

  /// What the next steps do.
  void begin(const StepPlan& plan) { plan_ = plan, most_first_ = kAll; }

  /// Where the step runs by parts: what it has found so far; else null.
  void follow(const StepState* found) { found_ = found; }

  /// Lists start at what most scenes need.
  void reserve() {
    const uint64_t first = first_length(scene_.topology.triangle_count());
    const ListLengths& expected = scene_.expected;
    reserve(scene_.contacts, first, expected[ListLengths::kContacts]);
    if (needs().is_earliest_only()) reserve(scene_.earliest, first, expected[ListLengths::kEarliest]);
    const uint64_t most = max(scene_.contacts.keys.capacity(), scene_.earliest.keys.capacity());
    reserve_order<Exec>(scene_.order, plan_.order, id_counts(), most, needs().has_data());
    scene_.columns.reserve(most, needs().columns());
    if (needs().columns().has(ContactField::kNormals)) scene_.normals.allocate(most);
    if (needs().tests_triangles() || needs().tests_crossings())
      begin_list(scene_.triangle_pairs, first, expected[ListLengths::kTrianglePairs]);
    reserve_edge_tests();
    if (!needs().has_narrow_phase()) return;
    for_each_kind(
        [&](ContactKind kind, bool is_wanted) {
          if (is_wanted && is_of_features(kind)) reserve_candidates(index_of(kind), first);
        },
        needs().kinds);
  }

  /// Makes room for what a step asked for; whether it has to run again. The first `kept` contacts stay.
  bool grow(const StepState& need, uint64_t kept) {
    bool short_of_room = false;
    const auto check = [&](auto& buffer, uint64_t count) {
      if (count <= buffer.capacity()) return;
      short_of_room = true;
      buffer.ensure(count);
    };
    for (int kind = 0; kind < kFeatureKinds; ++kind) {
      check(scene_.candidates[kind].kept, need.kept[kind]);
      check(scene_.candidates[kind].screened, need.screened[kind]);
      check(scene_.candidates[kind].resumable, need.resumable[kind]);
      check(scene_.blocking[kind].pairs, need.blocking[kind]);
    }
    check(scene_.triangle_pairs, max(need.triangle_pairs, need.crossing_pairs));
    reserve_edge_tests();
    const auto check_contacts = [&](ContactBuffers<Exec, Real>& contacts, uint64_t count, uint64_t kept_of_them) {
      if (count <= contacts.keys.capacity()) return;
      short_of_room = true;
      enlarge(contacts, count + count / 4, kept_of_them);
    };
    check_contacts(scene_.contacts, need.contacts, kept);
    check_contacts(scene_.earliest, need.earliest, 0);
    return short_of_room;
  }
  /// Looks at how many contacts a step found; whether they have to be put in order by another plan.
  bool reorders(const StepState& found) {
    return order_.observe(needs().is_earliest_only() ? found.earliest : found.contacts) && Exec::kLaunchesCost;
  }
  OrderPlan plan_order() const { return order_.plan(); }

  /// From kFast on: the narrow phase of one kind of features, over what the filter kept. Each loop that appends to a
  /// list is a part(put) of the step.
  template <class Kind, class Part>
  void detect(const Kind& kind, const Part& part) {
    exec_.stage(Kind::kNarrow, [&] {
      if (needs().advances) return detect_screened(kind, filter(kind), part);
      const AppendList<uint64_t> list = kept(Kind::kKind);
      if (needs().is_screened()) return detect_screened(kind, list, part);
      part([&] { run(kind, counted(list), list.items); });
      if (needs().looks_twice()) part([&] { look_again(kind); });
    });
  }
  void detect_triangles() {
    exec_.stage("narrow_tt", [&] {
      needs().settings.accuracy >= Accuracy::kCertified ? run_triangles<double>() : run_triangles<float>();
    });
  }

  /// Edges that go through triangles. The sure ones of them are contacts already, the host decides the others.
  void detect_crossings() {
    exec_.stage("narrow_et", [&] {
      const ResidentTopology<Exec>& topology = scene_.topology;
      const AppendList<uint64_t> left{scene_.edge_tests.all(), &scene_.state.data()->edge_tests};
      const Span<const uint64_t> pairs = scene_.triangle_pairs.all();
      exec_.for_each("rule_out_crossings", counted(pairs_of_triangles(ContactKind::kEdgeTriangle)),
                     RuleOutCrossings<Real>{scene_.end.data(), topology.corners(), topology.owned.all(),
                                            topology.rings(), pairs, early_exit(ContactKind::kEdgeTriangle), left});
      exec_.for_each("test_crossings", counted(left),
                     TestCrossings<Real>{scene_.end.data(), topology.corners(), topology.sides(), pairs, left.items,
                                         sink(ContactKind::kEdgeTriangle)});
    });
  }

  /// After the last kind: contacts that the report does not want go.
  void keep_earliest() {
    exec_.stage("earliest", [&] {
      StepState* state = scene_.state.data();
      exec_.for_each("keep_earliest", Counted{&state->contacts, scene_.contacts.keys.capacity()},
                     KeepEarliest<Real>{scene_.contacts.keys.all(), scene_.contacts.data.all(), &state->shortcut,
                                        list(scene_.earliest, &state->earliest)});
    });
  }
  /// The others are completed and put in order.
  void finish() {
    if (!needs().tells_contacts || (needs().is_any_hit() && !needs().settles())) return;
    if (needs().decides_in_step()) exec_.stage("decide", [&] { decide(); });
    if (needs().columns().has(ContactField::kNormals)) exec_.stage("normals", [&] { write_normals(); });
    exec_.stage("order", [&] { order(); });
  }

  // Lists that searches fill.
  /// Returns the list of candidates of a kind of features.
  AppendList<uint64_t> kept(ContactKind kind) {
    return list_of(candidates_of(kind).kept, &scene_.state.data()->kept[index_of(kind)]);
  }
  /// Returns the list of pairs of triangles of such a kind.
  AppendList<uint64_t> pairs_of_triangles(ContactKind kind) {
    return list_of(scene_.triangle_pairs, &pairs_counter(kind, *scene_.state.data()));
  }

  /// Makes the next searches end after `most` candidates; kAll: makes them complete.
  void look_at_first(uint64_t most) { most_first_ = most; }
  static constexpr uint64_t kAll = ~uint64_t{0};
  /// Drops the candidates that a search had no room for. Returns how many it found if those were too many, else 0.
  uint64_t cut_off(ContactKind kind, StepState& found) {
    uint64_t& count = is_of_features(kind) ? found.kept[index_of(kind)] : pairs_counter(kind, found);
    const AppendList<uint64_t> list = is_of_features(kind) ? kept(kind) : pairs_of_triangles(kind);
    if (count <= list.items.size()) return 0;
    const uint64_t all = std::exchange(count, list.items.size());
    exec_.upload(list.count, &count, sizeof(count));
    return all;
  }
  /// Empties the list of a kind and makes it larger, before a new search.
  void make_room(ContactKind kind, uint64_t count) {
    (is_of_features(kind) ? candidates_of(kind).kept : scene_.triangle_pairs).ensure(count);
    reserve_edge_tests();
  }
  EarlyExit early_exit(ContactKind kind) const {
    const bool is_settled = needs().is_exact() || kind == ContactKind::kEdgeTriangle;
    return {&scene_.state.data()->shortcut, needs().settings.report, is_settled};
  }

 private:
  const LevelNeeds& needs() const { return plan_.needs; }
  static Counted counted(const AppendList<uint64_t>& list) {
    return {list.count, list.items.size(), list.most_in_vain()};
  }
  CandidateBuffers<Exec>& candidates_of(ContactKind kind) { return scene_.candidates[index_of(kind)]; }
  static uint64_t& pairs_counter(ContactKind kind, StepState& state) {
    return kind == ContactKind::kEdgeTriangle ? state.crossing_pairs : state.triangle_pairs;
  }
  AppendList<uint64_t> list_of(const Buffer<uint64_t, Exec>& buffer, uint64_t* count) const {
    const Span<uint64_t> all = buffer.all();
    if (most_first_ == kAll) return {all, count};
    return {{all.data, min(all.size(), most_first_)}, count, true};
  }
  ContactBuffers<Exec, Real>& wanted() { return needs().is_earliest_only() ? scene_.earliest : scene_.contacts; }

  ContactList<Real> list(ContactBuffers<Exec, Real>& contacts, uint64_t* count) const {
    return {{contacts.keys.all(), count}, contacts.data.all()};
  }
  ContactSink<Real> sink(ContactKind kind) {
    return {list(scene_.contacts, &scene_.state.data()->contacts), early_exit(kind), ranks_.begin[index_of(kind)]};
  }

  void reserve(ContactBuffers<Exec, Real>& contacts, uint64_t count, uint64_t expected = 0) {
    contacts.keys.allocate(max(count, ListLengths::with_reserve(expected)));
    if (needs().has_data()) contacts.data.allocate(contacts.keys.capacity());
  }

  /// For as many as there may be pairs.
  void reserve_edge_tests() {
    if (needs().tests_crossings()) scene_.edge_tests.ensure(scene_.triangle_pairs.capacity());
  }

  void enlarge(ContactBuffers<Exec, Real>& contacts, uint64_t count, uint64_t kept) {
    if (kept == 0) return reserve(contacts, count);
    ContactBuffers<Exec, Real> larger(exec_);
    reserve(larger, count);
    exec_.copy(larger.keys.data(), contacts.keys.data(), kept * sizeof(uint64_t));
    if (needs().has_data()) exec_.copy(larger.data.data(), contacts.data.data(), kept * sizeof(ContactData<Real>));
    exec_.wait();
    contacts = std::move(larger);
  }

  void reserve_candidates(int kind, uint64_t count) {
    const ListLengths& expected = scene_.expected;
    CandidateBuffers<Exec>& candidates = scene_.candidates[kind];
    begin_list(candidates.kept, count, expected[ListLengths::kKept + kind]);
    if (needs().is_screened() || needs().looks_twice())
      begin_list(candidates.screened, count, expected[ListLengths::kScreened + kind]);
    if (needs().is_approached()) begin_list(candidates.resumable, count, expected[ListLengths::kResumable + kind]);
  }

  // The narrow phase of each level.
  HalfThicknesses halves() const { return scene_.halves(needs().settings); }
  template <class Kind, class Candidate>
  CcdQueries<Real, Kind, Candidate> queries(const Kind& kind, Span<const Candidate> candidates) const {
    return {scene_.positions_at_start(needs().is_ccd()),
            scene_.end.data(),
            needs().settings.thickness,
            {needs().settings.encoding, scene_.deviations(true)},
            needs().settings.delta,
            kind,
            candidates,
            halves()};
  }
  template <class Kind, class Candidate>
  CcdQueries<Real, Kind, Candidate> queries(const Kind& kind, const Buffer<Candidate, Exec>& candidates) const {
    return queries<Kind, Candidate>(kind, Span<const Candidate>(candidates.all()));
  }
  /// Filters the candidates that ways may have to be shortened for: contacts are among them.
  template <class Kind>
  AppendList<uint64_t> filter(const Kind& kind) {
    constexpr int k = kIndexOf<Kind>;
    StepState* state = scene_.state.data();
    const BlockingPairs<Exec>& blocking = scene_.blocking[k];
    const AppendList<uint64_t> filtered{blocking.filtered.all(), &state->filtered[k]};
    exec_.for_each("filter_candidates", Counted{&state->blocking[k], blocking.pairs.capacity()},
                   FilterCandidates<Real, Kind>{
                       scene_.start.data(), scene_.end.data(), kind, {&state->filter}, blocking.pairs.all(), filtered});
    return filtered;
  }
  template <class Kind, class Part>
  void detect_screened(const Kind& kind, const AppendList<uint64_t>& kept, const Part& part) {
    constexpr int k = kIndexOf<Kind>;
    StepState* state = scene_.state.data();
    const CandidateBuffers<Exec>& lists = candidates_of(Kind::kKind);
    part([&] {
      exec_.for_each("screen_ccd", counted(kept),
                     ScreenCcd<Real, Kind>{queries<Kind, uint64_t>(kind, kept.items),
                                           {lists.screened.all(), &state->screened[k]}});
    });
    if (!needs().is_approached()) {
      if (found_ != nullptr) expect_contacts(lists, found_->screened[k]);
      return part([&] { advance_ccd<float>(kind, &state->screened[k], lists.screened); });
    }
    part([&] {
      exec_.for_each_resumable(
          "approach_ccd", {&state->screened[k], lists.screened.capacity()}, &state->next_query[k][0],
          ApproachCcd<Real, Kind>{queries(kind, lists.screened), {lists.resumable.all(), &state->resumable[k]}});
    });
    if (found_ != nullptr) expect_contacts(lists, found_->resumable[k]);
    part([&] { advance_ccd<double>(kind, &state->resumable[k], lists.resumable); });
    part([&] {
      const Counted near_misses{&state->near_misses[k], lists.kept.capacity()};
      exec_.for_each_group(
          "follow_near_misses", near_misses,
          FollowNearMisses<Real, Kind>{reporter<double>(kind, lists.kept), lists.screened.all(), near_misses});
    });
  }
  /// Contacts are at most as many as queries. Room for all of them spares the queries a second run; where that takes
  /// more than the candidates' lists do, room is made as it is needed.
  void expect_contacts(const CandidateBuffers<Exec>& lists, uint64_t queries) {
    const uint64_t held = (lists.kept.capacity() + lists.screened.capacity()) * sizeof(uint64_t) +
                          lists.resumable.capacity() * sizeof(ResumableQuery),
                   most = found_->contacts + queries;
    if (most > scene_.contacts.keys.capacity() && most * (sizeof(uint64_t) + sizeof(ContactData<Real>)) <= held)
      enlarge(scene_.contacts, most, found_->contacts);
  }
  template <class Work, class Kind, class Candidate>
  CcdReporter<Work, Real, Kind, Candidate> reporter(const Kind& kind, const Buffer<Candidate, Exec>& candidates) {
    return {queries(kind, candidates), needs().settings.start_thickness, needs().skips_separating(), needs().is_exact(),
            sink(Kind::kKind)};
  }
  /// Near misses wait in lists whose candidates have all been looked at by now.
  template <class Work, class Kind, class Candidate>
  void advance_ccd(const Kind& kind, const uint64_t* count, const Buffer<Candidate, Exec>& candidates) {
    constexpr int k = kIndexOf<Kind>;
    StepState* state = scene_.state.data();
    NearMissList near_misses;
    if constexpr (std::is_same_v<Work, double>)
      near_misses = {{candidates_of(Kind::kKind).kept.all(), &state->near_misses[k]},
                     candidates_of(Kind::kKind).screened.all()};
    exec_.for_each_resumable("advance_ccd", {count, candidates.capacity()}, &state->next_query[k][1],
                             AdvanceCcd<Work, Real, Kind, Candidate>{reporter<Work>(kind, candidates), near_misses});
  }
  template <class Kind>
  void run(const Kind& kind, const Counted& count, Span<const uint64_t> candidates) {
    if (!needs().is_ccd()) return run_proximity(kind, count, candidates);
    exec_.for_each(
        "solve_cubic_ccd", count,
        SolveCubicCcd<Real, Kind>{scene_.positions_at_start(needs().is_ccd()), scene_.end.data(),
                                  needs().settings.thickness, kind, candidates, sink(Kind::kKind), halves()});
    if constexpr (std::is_same_v<Kind, VertexTriangle>)
      if (has_loose_elements_)
        exec_.for_each_resumable(
            "follow_loose_ccd", count, &scene_.state.data()->next_query[kIndexOf<Kind>][0],
            FollowLooseCcd<Real>{queries(kind, candidates_of(Kind::kKind).kept), sink(Kind::kKind)});
  }
  template <class Kind>
  void run_proximity(const Kind& kind, const Counted& count, Span<const uint64_t> candidates) {
    const ContactSink<Real> contacts = sink(Kind::kKind);
    if (needs().settings.accuracy == Accuracy::kFast)
      exec_.for_each("test_proximity", count,
                     TestProximity<Real, Kind>{scene_.end.data(), needs().settings.thickness, kind, candidates,
                                               contacts, halves()});
    else if (needs().settings.accuracy == Accuracy::kGuarded)
      exec_.for_each("certify_proximity", count, proximity<float>(kind, candidates));
    else
      exec_.for_each("certify_proximity", count, proximity<double>(kind, candidates));
  }
  template <class Work, class Kind>
  CertifyProximity<Work, Real, Kind> proximity(const Kind& kind, Span<const uint64_t> candidates) {
    const AppendList<uint64_t> near_misses{candidates_of(Kind::kKind).screened.all(),
                                           &scene_.state.data()->screened[kIndexOf<Kind>]};
    return {scene_.end.data(),
            needs().settings.thickness,
            needs().settings.encoding,
            kind,
            candidates,
            sink(Kind::kKind),
            near_misses,
            halves()};
  }
  template <class Kind>
  void look_again(const Kind& kind) {
    const AppendList<uint64_t> near_misses = proximity<double>(kind, {}).near_misses;
    exec_.for_each("separate_near_misses", Counted{near_misses.count, near_misses.items.size()},
                   SeparateNearMisses<Real, Kind>{proximity<double>(kind, near_misses.items)});
  }
  template <class Work>
  void run_triangles() {
    exec_.for_each("test_triangles", Counted{&scene_.state.data()->triangle_pairs, scene_.triangle_pairs.capacity()},
                   TestTriangles<Work, Real>{scene_.end.data(), scene_.topology.corners(), scene_.triangle_pairs.all(),
                                             sink(ContactKind::kTriangleTriangle)});
  }

  Counted wanted_count() {
    StepState* state = scene_.state.data();
    return {needs().is_earliest_only() ? &state->earliest : &state->contacts, wanted().keys.capacity()};
  }
  // Candidates have been looked at by now: contacts wait in their lists, which hold as many.
  void decide() {
    StepState* state = scene_.state.data();
    const FeatureKinds kinds = FeatureKinds::of(scene_.topology);
    const DecidedContacts<Real> contacts{scene_.positions_at_start(needs().is_ccd()),
                                         scene_.end.data(),
                                         needs().is_ccd(),
                                         kinds,
                                         ranks_,
                                         wanted().keys.all(),
                                         wanted().data.all(),
                                         &state->exact_decisions};
    DecideSoon<Real> soon{contacts, {}};
    for (int kind = 0; kind < kFeatureKinds; ++kind)
      soon.others[kind] = {scene_.candidates[kind].kept.all(), &state->decided_last[kind]};
    exec_.for_each("decide_soon", wanted_count(), soon);
    kinds.for_each([&]<class Kind>(const Kind&) {
      if (!value_of(needs().kinds, Kind::kKind)) return;
      const AppendList<uint64_t>& others = soon.others[kIndexOf<Kind>];
      exec_.for_each_resumable("decide_others", {others.count, others.items.size()},
                               &state->next_decision[kIndexOf<Kind>],
                               DecideOther<Real, Kind>{contacts, others.items, &state->undecided});
    });
  }
  void write_normals() {
    const bool has_float_times = std::is_same_v<Real, float> && needs().settings.accuracy == Accuracy::kFast;
    exec_.for_each(
        "write_normals", wanted_count(),
        WriteNormals<Real>{scene_.positions_at_start(needs().is_ccd()), scene_.end.data(),
                           FeatureKinds::of(scene_.topology), ranks_, has_float_times ? kClearInFloat : kClear,
                           wanted().keys.all(), wanted().data.all(), scene_.normals.all(),
                           needs().tells_features ? scene_.surfaces() : Surfaces<Real>{}});
  }
  void order() {
    StepState* state = scene_.state.data();
    const FieldSet columns = needs().columns();
    WriteContact<Real> write{{}, {}, ranks_, scene_.columns.columns(columns)};
    if (needs().has_data()) write.data = wanted().data.all();
    if (columns.has(ContactField::kNormals)) write.normals = scene_.normals.all();
    put_in_order(exec_, scene_.order,
                 Unordered<WriteContact<Real>>{wanted_count(), wanted().keys.all(), ranks_, &state->kinds, write},
                 plan_.order, id_counts(), &state->crowded_ranks);
  }

  Exec& exec_;
  const FeatureRanks& ranks_;
  SceneBuffers<Exec, Real>& scene_;
  bool has_loose_elements_ = false;
  const StepState* found_ = nullptr;
  uint64_t most_first_ = kAll;
  StepPlan plan_;
  OrderPredictor order_;
};

}  // namespace collided
