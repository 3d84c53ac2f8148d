// Benchmarks of the sort of CPU cores against tbb::parallel_sort, on keys as frames have them; an item is a key. Both
// sort the same keys in turn, so that whatever else the machine does hits both alike.

#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cmath>
#include <numeric>
#include <random>

#include "gpu/engines/lbvh/lbvh.hpp"
#include "tests/bench/stages/stage_bench.hpp"

namespace collided::test {
namespace {

constexpr uint64_t kGrain = 4096;  // of loops over all keys

template <class T>
Span<T> span_of(std::vector<T>& v) {
  return {v.data(), v.size()};
}

/// Pairs of features that are near each other, leaf by leaf, in no order of leaves.
std::vector<uint64_t> pair_keys(uint64_t count) {
  constexpr uint64_t kLeaf = 32, kPairsOfFeature = 4;
  std::mt19937_64 random(count);
  std::vector<uint64_t> keys(count);
  uint64_t first = 0;
  for (uint64_t i = 0; i < count; ++i) {
    if (i % kLeaf == 0) first = random() % (count / kPairsOfFeature);
    keys[i] = (first + random() % (kLeaf / 2)) << 32 | (first / 2 + random() % (2 * kLeaf));
  }
  return keys;
}

/// Of the triangles of a wavy sheet, row by row.
std::vector<uint64_t> leaf_keys(uint64_t count) {
  const uint64_t side = static_cast<uint64_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<Box<float>> boxes;
  for (uint64_t i = 0; i < count; ++i) {
    const float x = static_cast<float>(i % side) / static_cast<float>(side);
    const float y = static_cast<float>(i / side) / static_cast<float>(side);
    const Vec3<float> at{x, y, 0.5f + 0.3f * std::sin(9 * x) * std::cos(7 * y)};
    boxes.push_back({at, at});
  }
  const Box<float> bounds{{0, 0, 0}, {1, 1, 1}};
  const uint64_t extents = 1;
  std::vector<uint64_t> keys(count);
  std::vector<uint32_t> triangles(count), meeting(count);
  const MortonKeys make{
      &bounds,          {&bounds, &extents, count},      span_of(boxes), span_of(keys), span_of(triangles),
      span_of(meeting), MortonKeys::axis_bits_for(count)};
  for (uint64_t i = 0; i < count; ++i) make(i);
  return keys;
}

struct WriteKeys {
  Span<uint64_t> sorted;

  bool has_data() const { return false; }
  void operator()(uint64_t place, uint64_t key, uint64_t) const { sorted[place] = key; }
};

struct WriteKeysAndPlaces {
  Span<uint64_t> sorted;
  Span<uint32_t> places;

  bool has_data() const { return true; }
  void operator()(uint64_t place, uint64_t key, uint64_t from) const {
    sorted[place] = key;
    places[place] = static_cast<uint32_t>(from);
  }
};

/// A key without data, as tbb sorts it.
struct KeyAlone {
  uint64_t key;

  static KeyAlone of(uint64_t key, uint64_t) { return {key}; }
  uint32_t place() const { return 0; }
  bool operator<(const KeyAlone& other) const { return key < other.key; }
};

struct KeyAndPlace {
  uint64_t key, from;

  static KeyAndPlace of(uint64_t key, uint64_t from) { return {key, from}; }
  uint32_t place() const { return static_cast<uint32_t>(from); }
  bool operator<(const KeyAndPlace& other) const { return key != other.key ? key < other.key : from < other.from; }
};

/// The same keys for both sorts, and what each made of them.
template <class Entry>
class Contest {
 public:
  Contest(std::vector<uint64_t> given, int threads)
      : exec_(threads, 0),
        arena_(threads),
        given_(std::move(given)),
        keys_(given_),
        scratch_(size()),
        other_(size()),
        sorted_(size()),
        places_(size()),
        sorted_places_(size()),
        entries_(size()) {}

  void prepare() {
    keys_ = given_;
    std::iota(places_.begin(), places_.end(), 0u);
  }
  void sort_candidates() { sort_keys(WriteKeys{span_of(sorted_)}); }
  void sort_contacts() { sort_keys(WriteKeysAndPlaces{span_of(sorted_), span_of(sorted_places_)}); }
  void sort_leaves() {
    const int in_other = exec_.sort_pairs(
        "sort", MortonKeys::kBits, {span_of(keys_), span_of(sorted_), span_of(places_), span_of(sorted_places_)});
    if (in_other == 0) keys_.swap(sorted_), places_.swap(sorted_places_);
  }
  void sort_by_tbb() {
    CpuLoops& loops = exec_.host_loops();
    loops.for_each(size(), kGrain, [&](uint64_t i) { entries_[i] = Entry::of(given_[i], i); });
    arena_.execute([&] { tbb::parallel_sort(entries_.begin(), entries_.end()); });
    loops.for_each(size(), kGrain,
                   [&](uint64_t i) { scratch_[i] = entries_[i].key, places_[i] = entries_[i].place(); });
  }
  /// After sort_by_tbb().
  bool agrees() const { return sorted_ == scratch_ && sorted_places_ == places_; }
  uint64_t size() const { return given_.size(); }

 private:
  template <class Write>
  void sort_keys(const Write& write) {
    exec_.sort_keys("sort", Counted{nullptr, size()},
                    KeyArrays<Write>{span_of(keys_), span_of(scratch_), span_of(other_), write});
  }

  CpuExec exec_;
  tbb::task_arena arena_;
  std::vector<uint64_t> given_, keys_, scratch_, other_, sorted_;
  std::vector<uint32_t> places_, sorted_places_;
  std::vector<Entry> entries_;
};

template <class Work>
double seconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// `tbb_to_ours` is the median of the rounds' ratios.
template <class Entry>
void run_contest(Contest<Entry>& contest, void (Contest<Entry>::*sort)(), benchmark::State& state) {
  std::vector<double> ratios;
  double tbb_seconds = 0;
  for ([[maybe_unused]] auto _ : state) {
    contest.prepare();
    const double ours = seconds_of([&] { (contest.*sort)(); }), tbb = seconds_of([&] { contest.sort_by_tbb(); });
    if (!contest.agrees()) return state.SkipWithError("the two sorts disagree");
    state.SetIterationTime(ours);
    tbb_seconds += tbb;
    ratios.push_back(tbb / ours);
  }
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
  state.counters["tbb_to_ours"] = ratios[ratios.size() / 2];
  state.counters["tbb_us"] = 1e6 * tbb_seconds / static_cast<double>(ratios.size());
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(contest.size()));
}

template <class Entry>
void add_contest(const std::string& what, void (Contest<Entry>::*sort)(), std::vector<uint64_t> (*keys_of)(uint64_t)) {
  constexpr uint64_t kKeysInAll = 20'000'000, kMinRounds = 9, kMaxRounds = 201;
  for (const uint64_t count : {10'000u, 100'000u, 1'000'000u, 7'000'000u})
    for (const int threads : {1, 2}) {
      const std::string name = "sort/" + what + "/" + std::to_string(count) + "/threads:" + std::to_string(threads);
      const auto run = [=](benchmark::State& state) {
        Contest<Entry> contest(keys_of(count), threads);
        run_contest(contest, sort, state);
      };
      benchmark::RegisterBenchmark(name.c_str(), run)
          ->Unit(benchmark::kMicrosecond)
          ->UseManualTime()
          ->Iterations(static_cast<int64_t>(std::clamp(kKeysInAll / count, kMinRounds, kMaxRounds)));
    }
}

}  // namespace

void register_sorts() {
  add_contest("candidates", &Contest<KeyAlone>::sort_candidates, pair_keys);
  add_contest("contacts", &Contest<KeyAndPlace>::sort_contacts, pair_keys);
  add_contest("leaves", &Contest<KeyAndPlace>::sort_leaves, leaf_keys);
}

}  // namespace collided::test
