#pragma once
// From the candidates that the filter kept to contacts, at the frame's accuracy level (step 8 of Fig. 7). Everything is
// put in line for the backend; no length is read back.

#include "gpu/narrow/certified_proximity.hpp"
#include "gpu/narrow/fast_ccd.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/narrow/normal.hpp"
#include "gpu/narrow/proximity.hpp"
#include "gpu/narrow/triangle_pairs.hpp"
#include "gpu/step/buffers.hpp"
#include "gpu/step/order_predictor.hpp"
#include "gpu/step/plan.hpp"

namespace collided {

template <Executor Exec, class Real>
class NarrowPhase {
 public:
  NarrowPhase(Exec& exec, const SceneSpec& spec, const FeatureRanks& ranks, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), spec_(spec), ranks_(ranks), scene_(scene) {}

  /// What the next steps do.
  void begin(const StepPlan& plan) { plan_ = plan; }

  /// Lists start at what most scenes need.
  void reserve() {
    constexpr uint64_t kFirst = 1024;
    reserve(scene_.contacts, kFirst);
    if (needs().is_earliest_only()) reserve(scene_.earliest, kFirst);
    const uint64_t most = max(scene_.contacts.keys.capacity(), scene_.earliest.keys.capacity());
    reserve_order<Exec>(scene_.order, plan_.order, id_counts(), most, needs().has_data());
    scene_.columns.reserve(most, needs().columns());
    if (needs().columns().has(ContactField::kNormals)) scene_.normals.allocate(most);
    if (needs().tests_triangles() && scene_.triangle_pairs.capacity() == 0) scene_.triangle_pairs.allocate(kFirst);
    if (!needs().has_narrow_phase()) return;
    for (int kind = 0; kind < 2; ++kind) {
      if (!has_kind(kind)) continue;
      if (scene_.kept[kind].capacity() == 0) scene_.kept[kind].allocate(kFirst);
      if (needs().is_screened() && scene_.screened[kind].capacity() == 0) scene_.screened[kind].allocate(kFirst);
      if (needs().is_approached() && scene_.resumable[kind].capacity() == 0) scene_.resumable[kind].allocate(kFirst);
    }
  }

  /// Makes room for what a step asked for; whether it has to run again.
  bool grow(const StepState& need) {
    bool short_of_room = false;
    const auto check = [&](auto& buffer, uint64_t count) {
      if (count <= buffer.capacity()) return;
      short_of_room = true;
      buffer.ensure(count);
    };
    for (int kind = 0; kind < 2; ++kind) {
      check(scene_.kept[kind], need.kept[kind]);
      check(scene_.screened[kind], need.screened[kind]);
      check(scene_.resumable[kind], need.resumable[kind]);
    }
    check(scene_.triangle_pairs, need.triangle_pairs);
    for (auto [buffers, count] : {std::pair(&scene_.contacts, need.contacts), {&scene_.earliest, need.earliest}}) {
      if (count <= buffers->keys.capacity()) continue;
      short_of_room = true;
      reserve(*buffers, count + count / 4);
    }
    const bool reorder = order_.observe(needs().is_earliest_only() ? need.earliest : need.contacts);
    return (reorder && Exec::kLaunchesCost) || short_of_room;
  }
  OrderPlan plan_order() const { return order_.plan(); }

  /// From kFast on: the narrow phase of one kind of features, over what the filter kept.
  template <class Kind>
  void detect(const Kind& kind) {
    constexpr int k = kIndexOf<Kind>;
    StepState* state = scene_.state.data();
    exec_.stage(KindTraits<Kind>::kNarrow, [&] {
      const AppendList<uint64_t> list{scene_.kept[k].all(), &state->kept[k]};
      const Counted kept{list.count, list.items.size(), list.most_in_vain()};
      if (needs().is_screened())
        detect_screened(kind, kept);
      else
        run(kind, kept, scene_.kept[k].all());
    });
  }
  void detect_triangles() {
    exec_.stage("narrow_tt", [&] {
      needs().settings.accuracy >= Accuracy::kCertified ? run_triangles<double>() : run_triangles<float>();
    });
  }

  /// After the last kind: contacts that the report does not want go, the others are completed and put in order.
  void finish() {
    if (needs().is_any_hit() && !needs().is_exact()) return;
    if (needs().is_earliest_only()) exec_.stage("earliest", [&] { keep_earliest(); });
    if (needs().columns().has(ContactField::kNormals)) exec_.stage("normals", [&] { write_normals(); });
    exec_.stage("order", [&] { order(); });
  }

  bool has_kind(int kind) const { return kind == kIndexOf<EdgeEdge> ? spec_.edge_edge : spec_.vertex_triangle; }
  EarlyExit early_exit() const { return {&scene_.state.data()->shortcut, needs().settings.report, needs().is_exact()}; }

 private:
  const LevelNeeds& needs() const { return plan_.needs; }
  IdCounts id_counts() const {
    const uint64_t edges = ranks_.begin[index_of(ContactKind::kTriangleTriangle)] - ranks_.begin[kIndexOf<EdgeEdge>];
    return {ranks_.count(), max(edges, scene_.topology.triangles.capacity())};
  }
  ContactBuffers<Exec, Real>& wanted() { return needs().is_earliest_only() ? scene_.earliest : scene_.contacts; }

  ContactList<Real> list(ContactBuffers<Exec, Real>& contacts, uint64_t* count) const {
    return {{contacts.keys.all(), count}, contacts.data.all()};
  }
  ContactSink<Real> sink(ContactKind kind) {
    return {list(scene_.contacts, &scene_.state.data()->contacts), early_exit(), ranks_.begin[index_of(kind)]};
  }

  void reserve(ContactBuffers<Exec, Real>& contacts, uint64_t count) {
    contacts.keys.allocate(count);
    if (needs().has_data()) contacts.data.allocate(contacts.keys.capacity());
  }

  // The narrow phase of each level.
  template <class Kind, class Candidate>
  CcdQueries<Real, Kind, Candidate> queries(const Kind& kind, const Buffer<Candidate, Exec>& candidates) const {
    return {scene_.positions_at_start(),
            scene_.end.data(),
            spec_.thickness,
            needs().settings.delta,
            kind,
            candidates.all()};
  }
  template <class Kind>
  void detect_screened(const Kind& kind, const Counted& kept) {
    constexpr int k = kIndexOf<Kind>;
    StepState* state = scene_.state.data();
    const Counted screened{&state->screened[k], scene_.screened[k].capacity()};
    exec_.for_each(
        "screen_ccd", kept,
        ScreenCcd<Real, Kind>{queries(kind, scene_.kept[k]), {scene_.screened[k].all(), &state->screened[k]}});
    if (!needs().is_approached()) return advance_ccd<float>(kind, screened, scene_.screened[k]);
    Buffer<ResumableQuery, Exec>& resumable = scene_.resumable[k];
    exec_.for_each_resumable(
        "approach_ccd", screened, &state->next_query[k][0],
        ApproachCcd<Real, Kind>{queries(kind, scene_.screened[k]), {resumable.all(), &state->resumable[k]}});
    advance_ccd<double>(kind, {&state->resumable[k], resumable.capacity()}, resumable);
  }
  template <class Work, class Kind, class Candidate>
  void advance_ccd(const Kind& kind, const Counted& count, const Buffer<Candidate, Exec>& candidates) {
    exec_.for_each_resumable(
        "advance_ccd", count, &scene_.state.data()->next_query[kIndexOf<Kind>][1],
        AdvanceCcd<Work, Real, Kind, Candidate>{queries(kind, candidates), sink(KindTraits<Kind>::kKind)});
  }
  template <class Kind>
  void run(const Kind& kind, const Counted& count, Span<const uint64_t> candidates) {
    if (spec_.mode == Mode::kDcd) return run_proximity(kind, count, candidates);
    exec_.for_each(
        "solve_cubic_ccd", count,
        SolveCubicCcd<Real, Kind>{scene_.positions_at_start(), scene_.end.data(), static_cast<Real>(spec_.thickness),
                                  kind, candidates, sink(KindTraits<Kind>::kKind)});
  }
  template <class Kind>
  void run_proximity(const Kind& kind, const Counted& count, Span<const uint64_t> candidates) {
    const ContactSink<Real> contacts = sink(KindTraits<Kind>::kKind);
    if (needs().settings.accuracy == Accuracy::kFast)
      exec_.for_each(
          "test_proximity", count,
          TestProximity<Real, Kind>{scene_.end.data(), static_cast<Real>(spec_.thickness), kind, candidates, contacts});
    else if (needs().settings.accuracy == Accuracy::kGuarded)
      certify_proximity<float>(kind, count, candidates, contacts);
    else
      certify_proximity<double>(kind, count, candidates, contacts);
  }
  template <class Work, class Kind>
  void certify_proximity(const Kind& kind, const Counted& count, Span<const uint64_t> candidates,
                         const ContactSink<Real>& contacts) {
    exec_.for_each("certify_proximity", count,
                   CertifyProximity<Work, Real, Kind>{scene_.end.data(), spec_.thickness, kind, candidates, contacts});
  }
  template <class Work>
  void run_triangles() {
    exec_.for_each("test_triangles", Counted{&scene_.state.data()->triangle_pairs, scene_.triangle_pairs.capacity()},
                   TestTriangles<Work, Real>{scene_.end.data(), scene_.topology.triangles.all(),
                                             scene_.triangle_pairs.all(), sink(ContactKind::kTriangleTriangle)});
  }

  Counted wanted_count() {
    StepState* state = scene_.state.data();
    return {needs().is_earliest_only() ? &state->earliest : &state->contacts, wanted().keys.capacity()};
  }
  void write_normals() {
    const bool has_float_times = std::is_same_v<Real, float> && needs().settings.accuracy == Accuracy::kFast;
    exec_.for_each("write_normals", wanted_count(),
                   WriteNormals<Real>{
                       scene_.positions_at_start(), scene_.end.data(), VertexTriangle{scene_.topology.triangles.all()},
                       EdgeEdge{scene_.topology.edges.all()}, ranks_, has_float_times ? kClearInFloat : kClear,
                       wanted().keys.all(), wanted().data.all(), scene_.normals.all()});
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

  void keep_earliest() {
    StepState* state = scene_.state.data();
    exec_.for_each("keep_earliest", Counted{&state->contacts, scene_.contacts.keys.capacity()},
                   KeepEarliest<Real>{scene_.contacts.keys.all(), scene_.contacts.data.all(), &state->shortcut,
                                      list(scene_.earliest, &state->earliest)});
  }

  Exec& exec_;
  const SceneSpec& spec_;
  const FeatureRanks& ranks_;
  SceneBuffers<Exec, Real>& scene_;
  StepPlan plan_;
  OrderPredictor order_;
};

}  // namespace collided
