#pragma once
// How many frames a second are due, over time: constant, or in ramps.

#include <string>
#include <vector>

namespace collided::cli::load {

/// A stretch of time over which the rate changes evenly.
struct Stretch {
  double from = 0, to = 0;  ///< frames a second, at least 0
  double seconds = 0;       ///< > 0
};

/// "FROM:TO:SECONDS", or several joined by commas. Throws UsageError that names `option`.
std::vector<Stretch> parse_ramp(const std::string& option, const std::string& text);

class RateProfile {
 public:
  explicit RateProfile(std::vector<Stretch> stretches);
  RateProfile(double rate, double seconds) : RateProfile({{rate, rate, seconds}}) {}

  const std::vector<Stretch>& stretches() const { return stretches_; }
  double seconds() const { return seconds_; }
  /// Frames due in all of it; a fraction of one, too.
  double frames() const { return frames_; }
  double max_rate() const;
  /// Seconds from the start until so many frames are due; infinite if there are never that many.
  double time_of(double frames) const;

 private:
  std::vector<Stretch> stretches_;
  double seconds_ = 0, frames_ = 0;
};

}  // namespace collided::cli::load
