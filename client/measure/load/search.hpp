#pragma once
// The search for the highest rate that holds a bound: by doubling or halving, then by bisection. A rate fails that failed
// twice: one bad trial may be a daemon's first frames, or other work on its machine. It is told whether a rate held, and
// reads no clock.

#include <optional>

namespace collided::cli::load {

class RateSearch {
 public:
  static constexpr double kMinRate = 0.1, kMaxRate = 1e6;

  /// `first`: the rate to begin with; the search ends once the lowest rate that failed is at most 1 + `precision` times
  /// the highest that held.
  RateSearch(double first, double precision);
  /// The rate to try now; nothing once the search has ended.
  std::optional<double> next() const;
  /// Whether the rate of next() held.
  void report(bool held);
  /// The highest rate that held; nothing if none did.
  std::optional<double> best() const { return held_; }

 private:
  const double precision_;
  double rate_;
  bool failed_once_ = false;  ///< the rate of next(), in its only trial so far
  std::optional<double> held_, failed_;
};

}  // namespace collided::cli::load
