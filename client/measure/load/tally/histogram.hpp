#pragma once
// Times in a histogram of a fixed relative error, in the manner of HdrHistogram, on Boost.Histogram.

#include <cstdint>
#include <memory>
#include <utility>

namespace collided::cli::load {

/// The percentiles that reports have.
constexpr std::pair<const char*, double> kPercentiles[] = {{"p50", 50}, {"p90", 90},     {"p95", 95},
                                                           {"p99", 99}, {"p99.9", 99.9}, {"p99.99", 99.99}};

/// Milliseconds, from a microsecond to a quarter of an hour. What is outside lies in the first or last bin; minimum,
/// maximum and mean are exact.
class Histogram {
 public:
  static constexpr double kRelativeError = 0.001, kMinMs = 1e-3, kMaxMs = 1e6;

  Histogram();
  Histogram(Histogram&&) noexcept;
  Histogram& operator=(Histogram&&) noexcept;
  ~Histogram();

  void add(double ms);
  void add(const Histogram& other);

  uint64_t count() const { return count_; }
  double min() const { return min_; }  ///< 0 if it is empty, as the others
  double max() const { return max_; }
  double mean() const { return count_ ? sum_ / static_cast<double>(count_) : 0; }
  /// A time that at least `percent` of all times do not exceed: the upper end of its bin, so that it is never too low
  /// and at most kRelativeError too high.
  double percentile(double percent) const;

 private:
  struct Bins;
  std::unique_ptr<Bins> bins_;
  uint64_t count_ = 0;
  double sum_ = 0, min_ = 0, max_ = 0;
};

}  // namespace collided::cli::load
