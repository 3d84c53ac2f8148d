#pragma once
// From the candidates that the filter kept to contacts, at the frame's accuracy level (step 8 of Fig. 7). Everything is
// put in line for the backend; no length is read back.

#include "gpu/frame_check.hpp"
#include "gpu/narrow/certified_proximity.hpp"
#include "gpu/narrow/fast_ccd.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/narrow/proximity.hpp"
#include "gpu/narrow/triangle_pairs.hpp"
#include "gpu/scene_buffers.hpp"

namespace collided {

template <class Exec, class Real>
class NarrowPhase {
 public:
  NarrowPhase(Exec& exec, const SceneSpec& spec, const FeatureRanks& ranks, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), spec_(spec), ranks_(ranks), scene_(scene) {}

  void begin(const FrameSettings& settings) { settings_ = settings; }

  /// Lists start at what most scenes need.
  void reserve() {
    constexpr uint64_t kFirst = 1024;
    reserve(scene_.contacts, kFirst);
    if (is_earliest_only()) reserve(scene_.earliest, kFirst);
    const uint64_t most = larger(scene_.contacts.keys.capacity(), scene_.earliest.keys.capacity());
    scene_.order.reserve(ranks_.count, most);
    if (has_data()) scene_.sorted.allocate(most);
    if (tests_triangles() && scene_.triangle_pairs.capacity() == 0) scene_.triangle_pairs.allocate(kFirst);
    if (!has_narrow_phase()) return;
    for (int kind = 0; kind < 2; ++kind) {
      if (!has_kind(kind)) continue;
      if (scene_.kept[kind].capacity() == 0) scene_.kept[kind].allocate(kFirst);
      if (is_screened() && scene_.screened[kind].capacity() == 0) scene_.screened[kind].allocate(kFirst);
      if (is_approached() && scene_.suspects[kind].capacity() == 0) {
        scene_.suspects[kind].allocate(kFirst);
        scene_.near_suspects[kind].allocate(kFirst);
      }
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
      check(scene_.suspects[kind], need.suspects[kind]);
      check(scene_.near_suspects[kind], need.near_suspects[kind]);
    }
    check(scene_.triangle_pairs, need.triangle_pairs);
    for (auto [buffers, count] : {std::pair(&scene_.contacts, need.contacts), {&scene_.earliest, need.earliest}}) {
      if (count <= buffers->keys.capacity()) continue;
      short_of_room = true;
      reserve(*buffers, count + count / 4);
    }
    return short_of_room;
  }

  /// From kFast on: the narrow phase of one kind of features, over what the filter kept.
  template <class Kind>
  void detect(const Kind& kind) {
    constexpr int k = KindTraits<Kind>::kIndex;
    StepState* state = scene_.state.data();
    exec_.stage(KindTraits<Kind>::kNarrow, [&] {
      const Counted kept{&state->kept[k], scene_.kept[k].capacity()};
      if (is_screened())
        detect_screened(kind, kept);
      else
        run(kind, kept, scene_.kept[k].all());
    });
  }
  void detect_triangles() {
    exec_.stage("narrow_tt",
                [&] { settings_.accuracy >= Accuracy::kCertified ? run_triangles<double>() : run_triangles<float>(); });
  }

  /// After the last kind: contacts that the report does not want go, the others are put in order.
  void order() {
    if (settings_.report == Report::kAnyHit && !is_exact()) return;
    exec_.stage("order", [&] {
      if (is_earliest_only()) keep_earliest();
      ContactBuffers<Exec, Real>& contacts = wanted();
      StepState* state = scene_.state.data();
      const Counted count{is_earliest_only() ? &state->earliest : &state->contacts, contacts.keys.capacity()};
      Span<const ContactData<Real>> data;
      if (has_data()) data = contacts.data.all();
      put_in_order(exec_, scene_.order, count, contacts.keys.all(), data, scene_.sorted.all(), &state->crowded_ranks);
    });
  }

  bool is_exact() const { return settings_.accuracy == Accuracy::kExact; }
  bool is_earliest_only() const { return settings_.report == Report::kEarliestOnly; }
  bool has_narrow_phase() const { return settings_.accuracy != Accuracy::kCandidates; }
  /// Triangles of a frame are tested at every level; in CCD their boxes are all there is.
  bool tests_triangles() const { return spec_.triangle_triangle && spec_.mode == Mode::kDcd; }
  bool has_data() const { return has_narrow_phase() || tests_triangles(); }
  bool has_kind(int kind) const { return kind == kVertexTriangleKind ? spec_.vertex_triangle : spec_.edge_edge; }
  Hurry hurry() const { return {&scene_.state.data()->shortcut, settings_.report, is_exact()}; }

 private:
  /// Whether a fixed direction is tried before the features are followed, and whether float goes ahead of double.
  bool is_screened() const { return spec_.mode == Mode::kCcd && settings_.accuracy >= Accuracy::kGuarded; }
  bool is_approached() const { return is_screened() && settings_.accuracy >= Accuracy::kCertified; }
  const Vec3<Real>* start() const { return spec_.mode == Mode::kCcd ? scene_.start.data() : scene_.end.data(); }
  const Vec3<Real>* end() const { return scene_.end.data(); }
  ContactBuffers<Exec, Real>& wanted() { return is_earliest_only() ? scene_.earliest : scene_.contacts; }

  uint32_t first_rank(const VertexTriangle&) const { return 0; }
  uint32_t first_rank(const EdgeEdge&) const { return ranks_.first_edge; }
  ContactList<Real> list(ContactBuffers<Exec, Real>& contacts, uint64_t* count) const {
    return {{contacts.keys.all(), count}, contacts.data.all()};
  }
  ContactSink<Real> sink(uint32_t first_rank) {
    return {list(scene_.contacts, &scene_.state.data()->contacts), hurry(), first_rank};
  }

  void reserve(ContactBuffers<Exec, Real>& contacts, uint64_t count) {
    contacts.keys.allocate(count);
    if (has_data()) contacts.data.allocate(contacts.keys.capacity());
  }

  // The narrow phase of each level.
  template <class Kind>
  void detect_screened(const Kind& kind, const Counted& kept) {
    constexpr int k = KindTraits<Kind>::kIndex;
    StepState* state = scene_.state.data();
    exec_.for_each("screen_ccd", kept,
                   ScreenCcd<Real, Kind>{start(),
                                         end(),
                                         spec_.thickness,
                                         kind,
                                         scene_.kept[k].all(),
                                         {scene_.screened[k].all(), &state->screened[k]}});
    const Counted screened{&state->screened[k], scene_.screened[k].capacity()};
    if (!is_approached())
      return advance_ccd<float>(kind, screened, Span<const uint64_t>(scene_.screened[k].all()), kMaxAdvances, {});
    // Those that need many iterations are gathered twice, for a warp takes as long as the slowest of its queries.
    constexpr int kAtFirst = 2, kThen = 3;
    approach(kind, screened, Span<const uint64_t>(scene_.screened[k].all()), scene_.suspects[k], state->suspects[k],
             kAtFirst);
    approach(kind, {&state->suspects[k], scene_.suspects[k].capacity()}, Span<const Suspect>(scene_.suspects[k].all()),
             scene_.near_suspects[k], state->near_suspects[k], kThen);
    // The list of suspects is free again.
    const AppendList<Suspect> late{scene_.suspects[k].all(), &state->late[k]};
    advance_ccd<double>(kind, {&state->near_suspects[k], scene_.near_suspects[k].capacity()},
                        Span<const Suspect>(scene_.near_suspects[k].all()), kThen, late);
    advance_ccd<double>(kind, {&state->late[k], scene_.suspects[k].capacity()},
                        Span<const Suspect>(scene_.suspects[k].all()), kMaxAdvances, {});
  }
  template <class Kind, class Candidate>
  void approach(const Kind& kind, const Counted& count, Span<const Candidate> candidates,
                const Buffer<Suspect, Exec>& suspects, uint64_t& suspect_count, int iterations) {
    exec_.for_each("approach_ccd", count,
                   ApproachCcd<Real, Kind, Candidate>{start(),
                                                      end(),
                                                      spec_.thickness,
                                                      settings_.delta,
                                                      kind,
                                                      candidates,
                                                      {suspects.all(), &suspect_count},
                                                      iterations});
  }
  template <class Work, class Kind, class Candidate>
  void advance_ccd(const Kind& kind, const Counted& count, Span<const Candidate> candidates, int iterations,
                   const AppendList<Suspect>& late) {
    exec_.for_each("advance_ccd", count,
                   AdvanceCcd<Work, Real, Kind, Candidate>{start(), end(), spec_.thickness, settings_.delta, kind,
                                                           candidates, sink(first_rank(kind)), iterations, late});
  }
  template <class Kind>
  void run(const Kind& kind, const Counted& count, Span<const uint64_t> candidates) {
    if (spec_.mode == Mode::kDcd) return run_proximity(kind, count, candidates);
    exec_.for_each("solve_cubic_ccd", count,
                   SolveCubicCcd<Real, Kind>{start(), end(), static_cast<Real>(spec_.thickness), kind, candidates,
                                             sink(first_rank(kind))});
  }
  template <class Kind>
  void run_proximity(const Kind& kind, const Counted& count, Span<const uint64_t> candidates) {
    const ContactSink<Real> contacts = sink(first_rank(kind));
    if (settings_.accuracy == Accuracy::kFast)
      exec_.for_each("test_proximity", count,
                     TestProximity<Real, Kind>{end(), static_cast<Real>(spec_.thickness), kind, candidates, contacts});
    else if (settings_.accuracy == Accuracy::kGuarded)
      certify_proximity<float>(kind, count, candidates, contacts);
    else
      certify_proximity<double>(kind, count, candidates, contacts);
  }
  template <class Work, class Kind>
  void certify_proximity(const Kind& kind, const Counted& count, Span<const uint64_t> candidates,
                         const ContactSink<Real>& contacts) {
    exec_.for_each("certify_proximity", count,
                   CertifyProximity<Work, Real, Kind>{end(), spec_.thickness, kind, candidates, contacts});
  }
  template <class Work>
  void run_triangles() {
    exec_.for_each("test_triangles", Counted{&scene_.state.data()->triangle_pairs, scene_.triangle_pairs.capacity()},
                   TestTriangles<Work, Real>{end(), scene_.topology.triangles.all(), scene_.triangle_pairs.all(),
                                             sink(ranks_.first_triangle)});
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
  FrameSettings settings_{};
};

}  // namespace collided
