#pragma once
// Steps 6 to 8 of Fig. 7 for all kinds of contacts that a frame wants: candidates, then contacts.

#include "gpu/narrow/features.hpp"
#include "gpu/step/candidate_phase.hpp"
#include "gpu/step/narrow_phase.hpp"
#include "gpu/step/shorten_phase.hpp"
#include "gpu/step/step_run.hpp"

namespace collided {

template <Executor Exec, class Real>
class ContactPhase {
 public:
  ContactPhase(const StepContext<Exec, Real>& context, StepRun<Exec>& run, CandidatePhase<Exec, Real>& candidates,
               NarrowPhase<Exec, Real>& narrow)
      : context_(context), run_(run), candidates_(candidates), narrow_(narrow) {}

  /// The next steps have these needs.
  void begin(const LevelNeeds& needs) { needs_ = needs; }

  /// Crossings are looked for beside the others, but where one kind may answer for all, or shares its list.
  void detect_all() {
    if (!needs_.kinds.edge_triangle) return detect_others();
    if (!needs_.is_any_hit() && !needs_.kinds.triangle_triangle)
      return context_.exec.concurrently([&] { detect_others(); }, [&] { detect_crossings(); });
    detect_others();
    detect_crossings();
  }
  /// Finds the pairs that ways are shortened for, looks at all of them, and finds the contacts if they are wanted.
  void detect_blocking(ShortenPhase<Exec, Real>& shorten) {
    part([&] { candidates_.search(needs_.kinds); });
    side_by_side([&](const auto& kind) { part([&] { shorten.screen(kind); }); });
    shorten.reserve();  // a step by parts has made room for pairs since
    if (!needs_.tells_contacts) return shorten.judge_ways();
    context_.exec.concurrently([&] { detect_side_by_side(); }, [&] { shorten.judge_ways(); });
  }
  void keep_earliest() {
    part([&] { narrow_.keep_earliest(); });
  }
  /// Whether nothing else matters.
  bool has_hit() const { return needs_.is_any_hit() && !needs_.advances && run_.found().shortcut.has_contact != 0; }
  /// A step has ended: the next one at kAnyHit guesses that it is like this one.
  void finish() {
    if (needs_.is_any_hit()) had_hit_ = has_hit();
  }

 private:
  template <class Put>
  void part(const Put& put) {
    const uint64_t contacts_before = run_.found().contacts;
    run_.part(put, [&] { return narrow_.grow(run_.found(), contacts_before); });
  }
  /// All kinds but crossings.
  void detect_others() {
    if (is_of_features(first_of(needs_.kinds))) detect_features();
    if (needs_.kinds.triangle_triangle)
      detect_triangles(
          ContactKind::kTriangleTriangle, [&] { candidates_.search_triangles(); }, [&] { narrow_.detect_triangles(); });
  }
  void detect_crossings() {
    detect_triangles(
        ContactKind::kEdgeTriangle, [&] { candidates_.search_crossings(); }, [&] { narrow_.detect_crossings(); });
  }
  /// use(kind) for the kinds of features that are wanted.
  template <class Use>
  void for_each_features(const Use& use) const {
    FeatureKinds::of(context_.scene.topology).for_each([&]<class Kind>(const Kind& kind) {
      if (value_of(needs_.kinds, Kind::kKind)) use(kind);
    });
  }

  void detect_features() {
    if (needs_.has_narrow_phase() && needs_.is_any_hit()) return detect_in_turn();
    part([&] { candidates_.search(needs_.kinds); });
    if (needs_.has_narrow_phase()) detect_side_by_side();
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
  /// Tests the first candidates before the search makes more: bodies in one place make millions, and the first tells.
  /// After that, the candidates that the list has room for are tested before the list grows.
  template <class Search, class Detect>
  void look_for_hit(ContactKind kind, const Search& search, const Detect& detect) {
    if (!run_.is_by_parts()) return search(), detect();
    if (has_hit()) return;
    run_.save();
    constexpr uint64_t kFirst = 4096;
    for (uint64_t most = had_hit_ ? kFirst : narrow_.kAll;; most = narrow_.kAll) {
      narrow_.look_at_first(most);
      run_.part(search, [] { return false; });
      const uint64_t found = narrow_.cut_off(kind, run_.found());
      detect();
      if (found == 0 || has_hit()) break;
      narrow_.make_room(kind, found);
      run_.restore();
    }
    narrow_.look_at_first(narrow_.kAll);
  }
  void detect_side_by_side() {
    side_by_side([&](const auto& kind) { detect(kind); });
  }
  /// use(kind) of the first kind beside that of the others.
  template <class Use>
  void side_by_side(const Use& use) const {
    int kinds = 0;
    for_each_features([&](const auto&) { ++kinds; });
    const auto use_those = [&](bool first) {
      for_each_features([&]<class Kind>(const Kind& kind) {
        if ((Kind::kKind == first_of(needs_.kinds)) == first) use(kind);
      });
    };
    if (kinds == 1) return use_those(true);
    context_.exec.concurrently([&] { use_those(true); }, [&] { use_those(false); });
  }

  /// Contacts of one of the kinds that pairs of triangles have.
  template <class Search, class Test>
  void detect_triangles(ContactKind kind, const Search& search, const Test& test) {
    const auto detect = [&] { part(test); };
    if (needs_.is_any_hit()) return look_for_hit(kind, search, detect);
    part(search);
    if (needs_.tests(kind)) detect();
  }

  const StepContext<Exec, Real>& context_;
  StepRun<Exec>& run_;
  CandidatePhase<Exec, Real>& candidates_;
  NarrowPhase<Exec, Real>& narrow_;
  LevelNeeds needs_;
  bool had_hit_ = true;  ///< the last step at kAnyHit; as good as a guess before the first
};

}  // namespace collided
