#pragma once
// ApproachCcd for four candidates at a time: one that is done makes room for the next.

#include "gpu/exec/cpu/in_ranges.hpp"
#include "gpu/narrow/cpu/advancement.hpp"
#include "gpu/narrow/cpu/four_queries.hpp"

namespace collided {

template <class Real, class Kind>
class FourApproaches {
  using Approach = ApproachCcd<Real, Kind>;

 public:
  static constexpr uint64_t kItems = 128;

  FourApproaches(const Approach& approach, uint64_t first, uint64_t end)
      : approach_(approach), first_(first), end_(end), next_(first) {}

  void run() {
    for (int lane = 0; lane < 4; ++lane) begin_next(lane);
    while (busy_ != 0) {
      const FourOutcomes outcomes = features_.iterate();
      for (int lane = 0; lane < 4; ++lane)
        if ((outcomes.over & busy_) >> lane & 1u) {
          if ((outcomes.hits >> lane & 1u) != 0) push({keys_[lane], features_.progress(lane)});
          begin_next(lane);
        }
    }
    approach_.resumable.push_all(resumable_, count_);
  }

 private:
  /// The lane goes on with another query, if there is one.
  void begin_next(int lane) {
    busy_ &= ~(1u << lane);
    for (; next_ < end_; ++next_) {
      const int from = static_cast<int>((next_ - first_) % 4);
      if (from == 0) load();
      if ((queries_.loaded >> from & 1u) != 0) {
        features_.begin(lane, queries_.d, queries_.thickness, delta_, from);
        keys_[lane] = queries_.keys[from];
        busy_ |= 1u << lane;
        ++next_;
        return;
      }
      push({queries_.keys[from], Progress{}});
    }
  }
  [[gnu::flatten]] void load() {
    queries_.load(approach_.queries, next_, end_);
    delta_ = approach_.delta_of(queries_.d);
  }
  void push(const ResumableQuery& query) { resumable_[count_++] = query; }

  const Approach& approach_;
  const uint64_t first_, end_;
  uint64_t next_;
  FourQueries<Kind> queries_;  ///< the four that the next one is of
  Four<float> delta_;
  FourAdvancements<DifferenceOf<Kind>::kCount> features_{Approach::kIterationsInFloat};
  uint64_t keys_[4];
  uint32_t busy_ = 0;
  ResumableQuery resumable_[kItems];
  uint64_t count_ = 0;
};

template <class Real, class Kind>
struct InRanges<ApproachCcd<Real, Kind>> {
  static constexpr uint64_t kItems = FourApproaches<Real, Kind>::kItems;

  static void run(const ApproachCcd<Real, Kind>& approach, uint64_t first, uint64_t end) {
    FourApproaches<Real, Kind>(approach, first, end).run();
  }
};

}  // namespace collided
