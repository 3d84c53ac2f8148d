#pragma once
// ScreenHulls for four candidates at a time.

#include "gpu/exec/cpu/in_ranges.hpp"
#include "gpu/narrow/cpu/four_queries.hpp"
#include "gpu/narrow/hulls_apart.hpp"

namespace collided {

template <class T>
struct PositionNoise<Four<T>> : PositionNoise<T> {};

template <class Real, class Kind>
struct InRanges<ScreenHulls<Real, Kind>> {
  static constexpr uint64_t kItems = 512;

  [[gnu::flatten]] static void run(const ScreenHulls<Real, Kind>& screen, uint64_t first, uint64_t end) {
    uint64_t survivors[kItems];
    uint64_t count = 0;
    FourDifferences<Kind> d{};
    for (; first < end; first += 4) {
      const uint32_t kept = ~are_apart(screen, first, end, d);
      for (uint64_t lane = 0; lane < min(end - first, uint64_t{4}); ++lane) {
        survivors[count] = screen.candidates[first + lane];
        count += kept >> lane & 1u;
      }
    }
    screen.survivors.push_all(survivors, count);
  }

 private:
  /// Bit k: whether the k-th of four is. Those after the last one are copies of it. `d`: for their differences.
  static uint32_t are_apart(const ScreenHulls<Real, Kind>& screen, uint64_t first, uint64_t end,
                            FourDifferences<Kind>& d) {
    FeaturePoints<Four<Real>> ways;
    Four<double> reach{};
    for (int lane = 0; lane < 4; ++lane) {
      const Stencil s = screen.kind.stencil(screen.candidates[min(first + static_cast<uint64_t>(lane), end - 1)]);
      const FeaturePoints<Real> way = points_of(s, screen.start, screen.target);
      reach.set(lane, screen.reach(s));
      for (int k = 0; k < 4; ++k) set_lane(ways.start[k], lane, way.start[k]), set_lane(ways.end[k], lane, way.end[k]);
    }
    const uint32_t loaded = load_differences<Kind, Four<float>>(ways, d).bits();
    const auto distance = hulls_distance<Four<Real>>(reach, largest_coordinate(ways));
    return loaded & hulls_are_apart<Kind>(d, ways, distance).bits();
  }
};

}  // namespace collided
