#pragma once
// What a thread on CPU cores does with the pairs that it finds: which of them, or of the candidates of features that
// they have, go to which of the sink's lists.

#include <bit>
#include <optional>
#include <utility>

#include "gpu/search/cpu/feature_tests.hpp"
#include "gpu/search/cpu/list_writer.hpp"
#include "gpu/search/neighbours.hpp"

namespace collided {

/// For sinks that want pairs as they are.
template <class Sink>
class PairTaker {
 public:
  explicit PairTaker(const Sink& sink) : sink_(sink), list_(sink.pairs) {}

  /// A triangle that may soon be in pairs.
  void prefetch(uint32_t) const {}
  void take(uint32_t a, uint32_t b) {
    ++pairs_;
    uint64_t key;
    if (sink_.keeps(min(a, b), max(a, b), key)) list_.push(key);
  }
  /// After the last pair.
  void finish() {
    list_.flush();
    sink_.add(pairs_, 0, 0);
  }

 private:
  const Sink& sink_;
  ListWriter<uint64_t> list_;
  uint64_t pairs_ = 0;
};

/// Tests that pairs have passed, until there are many: neither adding nor going through them takes a branch that
/// depends on a pair, which the processor could only guess.
class PassedTests {
 public:
  void add(uint32_t a, uint32_t b, uint32_t tests) {
    pairs_[size_] = {a, b, tests};
    size_ += tests != 0 ? 1 : 0;
  }
  bool is_full() const { return size_ == kMax; }

  /// use(a, b, test) for each, and how many that were; then there are none.
  template <class Use>
  uint64_t drain(const Use& use) {
    uint64_t count = 0;
    pairs_[size_].tests = 0;
    uint32_t left = pairs_[0].tests;
    for (uint32_t i = 0; i < size_; ++count) {
      use(pairs_[i].a, pairs_[i].b, std::countr_zero(left));
      left &= left - 1;
      i += left == 0 ? 1 : 0;
      left = left == 0 ? pairs_[i].tests : left;
    }
    size_ = 0;
    return count;
  }

 private:
  static constexpr uint32_t kMax = 64;
  struct Pair {
    uint32_t a, b, tests;
  };
  Pair pairs_[kMax + 1];
  uint32_t size_ = 0;
};

/// Whether a sink lists the tests of candidates (PackedTest), not the candidates.
template <class Sink>
constexpr bool kListsTests = requires {
  Sink::kListsTests;
};

/// For sinks that want the candidates of pairs.
template <class Sink>
class CandidateTaker {
 public:
  CandidateTaker(const Sink& sink, const FeatureBoxes* features)
      : sink_(sink), features_(features), first_(sink.vertex_triangle), second_(sink.edge_edge) {}

  /// A triangle that may soon be in pairs.
  void prefetch(uint32_t triangle) const {
    const char* features = reinterpret_cast<const char*>(&features_[triangle]);
    for (size_t byte = 0; byte < sizeof(FeatureBoxes); byte += 64) __builtin_prefetch(features + byte);
  }
  /// Fastest if `a` is often the same as before.
  void take(uint32_t a, uint32_t b) {
    ++pairs_;
    if (!row_ || row_of_ != a) row_.emplace(features_[a]), row_of_ = a;
    constexpr uint32_t kFirstKind = (1u << Sink::kFirstOfSecondKind) - 1u;
    const uint32_t tests =
        row_->tests(features_[b]) & Sink::wanted_tests(features_[a].role(), features_[b].role(), a < b);
    first_tests_.add(a, b, tests & kFirstKind);
    second_tests_.add(a, b, tests & ~kFirstKind);
    if (first_tests_.is_full()) take_first();
    if (second_tests_.is_full()) take_second();
  }
  /// After the last pair.
  void finish() {
    take_first();
    take_second();
    first_.flush();
    second_.flush();
    sink_.add(pairs_, candidates_[0], candidates_[1]);
  }

 private:
  void take_first() {
    uint64_t dropped = 0;
    const uint64_t passed = first_tests_.drain([&](uint32_t a, uint32_t b, int test) {
      if (!confirms_first(a, b, test) || sink_.excludes_first(a, b, test)) return void(++dropped);
      if (!ask(a, b, test, [&](auto... of) { return sink_.keeps_first(of...); })) return;
      first_.push(first_entry(a, b, test));
    });
    candidates_[0] += passed - dropped;
  }
  void take_second() {
    uint64_t dropped = 0;
    const uint64_t passed = second_tests_.drain([&](uint32_t a, uint32_t b, int test) {
      if (!confirms_second(a, b, test) || sink_.excludes_second(a, b, test)) return void(++dropped);
      if (!ask(a, b, test, [&](auto... of) { return sink_.keeps_second(of...); })) return;
      second_.push(second_entry(a, b, test));
    });
    candidates_[1] += passed - dropped;
  }
  /// Whether boxes overlap that make a candidate, where those in the records do.
  bool confirms_first(uint32_t a, uint32_t b, int test) const {
    if constexpr (!kRoundsBoxes<typename Sink::Number>) return true;
    if (test >= 3) std::swap(a, b), test -= 3;
    const FeatureBoxes &v = features_[a], &t = features_[b];
    return sink_.template confirms<FirstFeature::kVertex>(
        v.corners.get(test), t.edges.get(3), {{v.vertex[test], t.vertex[0], t.vertex[1], t.vertex[2]}}, a, b);
  }
  bool confirms_second(uint32_t a, uint32_t b, int test) const {
    if constexpr (!kRoundsBoxes<typename Sink::Number>) return true;
    const int k = first_edge_of(test), m = second_edge_of(test), after_k = k < 2 ? k + 1 : 0,
              after_m = m < 2 ? m + 1 : 0;
    const FeatureBoxes &e = features_[a], &f = features_[b];
    return sink_.template confirms<FirstFeature::kEdge>(
        e.edges.get(k), f.edges.get(m), {{e.vertex[k], e.vertex[after_k], f.vertex[m], f.vertex[after_m]}}, a, b);
  }
  uint64_t first_entry(uint32_t a, uint32_t b, int test) const {
    if constexpr (kListsTests<Sink>) return packed(a, b, test, 0);
    const bool of_first = test < 3;
    return sink_.first_key(features_[of_first ? a : b].vertex[of_first ? test : test - 3], of_first ? b : a);
  }
  uint64_t second_entry(uint32_t a, uint32_t b, int test) const {
    if constexpr (kListsTests<Sink>) return packed(a, b, test, Sink::kFirstOfSecondKind);
    return sink_.second_key(features_[a].edge[first_edge_of(test)], features_[b].edge[second_edge_of(test)]);
  }
  static uint64_t packed(uint32_t a, uint32_t b, int test, int first_of_kind) {
    return a < b ? PackedTest{a, b, test - first_of_kind}.packed()
                 : PackedTest{b, a, test_of_swapped(test) - first_of_kind}.packed();
  }
  /// The filter's answer for the lower triangle first: the order of points may matter to it.
  template <class Keeps>
  static bool ask(uint32_t a, uint32_t b, int test, const Keeps& keeps) {
    if constexpr (Sink::kKeepsAll) return true;
    return a < b ? keeps(a, b, test) : keeps(b, a, test_of_swapped(test));
  }

  const Sink& sink_;
  const FeatureBoxes* features_;  ///< of each triangle
  std::optional<FeatureRow> row_;
  uint32_t row_of_ = 0;
  PassedTests first_tests_, second_tests_;
  ListWriter<uint64_t> first_, second_;
  uint64_t pairs_ = 0, candidates_[2] = {0, 0};
};

/// The one of them that a sink needs.
template <class Sink>
struct TakerOf {
  using Type = CandidateTaker<Sink>;
};
template <class Sink>
requires Sink::kTakesPairs struct TakerOf<Sink> {
  using Type = PairTaker<Sink>;
};
template <class Sink>
using Taker = typename TakerOf<Sink>::Type;

}  // namespace collided
