#pragma once
// ScreenCcd for four candidates at a time.

#include "gpu/exec/cpu/in_ranges.hpp"
#include "gpu/narrow/cpu/four_queries.hpp"

namespace collided {

template <class Real, class Kind>
struct InRanges<ScreenCcd<Real, Kind>> {
  static constexpr uint64_t kItems = 512;

  [[gnu::flatten]] static void run(const ScreenCcd<Real, Kind>& screen, uint64_t first, uint64_t end) {
    uint64_t survivors[kItems];
    uint64_t count = 0;
    FourQueries<Kind> four;
    for (; first < end; first += 4) {
      four.load(screen.queries, first, end);
      const auto apart = ScreenCcd<Real, Kind>::is_apart(four.d, four.thickness);
      const uint32_t kept = ~(four.loaded & apart.bits());
      for (uint64_t lane = 0; lane < min(end - first, uint64_t{4}); ++lane) {
        survivors[count] = four.keys[lane];
        count += kept >> lane & 1u;
      }
    }
    screen.survivors.push_all(survivors, count);
  }
};

}  // namespace collided
