#pragma once
// When each frame of one stream should be sent, whatever became of the frames before it.

#include <cstdint>
#include <random>

#include "client/measure/load/pace/profile.hpp"

namespace collided::cli::load {

enum class Arrivals {
  kFixed,    ///< evenly spaced
  kPoisson,  ///< each independent of the others, as those of many users are
};

/// Which of the streams a schedule is for.
struct StreamPlace {
  uint32_t index = 0, count = 1;
};

class Schedule {
 public:
  /// The fixed schedules of all streams are spread evenly over the interval between two frames; the Poisson ones are
  /// independent, and the same for the same seed. `profile` must outlive it.
  Schedule(const RateProfile& profile, Arrivals arrivals, StreamPlace place, uint64_t seed);
  /// Seconds from the start until the next frame; infinite after the last.
  double next();

 private:
  double gap();

  const RateProfile& profile_;
  const Arrivals arrivals_;
  std::mt19937_64 random_;
  double due_;  ///< number of frames due by the time of the next one
};

}  // namespace collided::cli::load
