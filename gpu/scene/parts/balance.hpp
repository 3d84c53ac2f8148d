#pragma once
// How large the share of each part of a scene is: parts are to take equally long.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/base/share.hpp"
#include "gpu/step/plan/trials.hpp"

namespace collided {

/// Shares are equal at first. Where the slowest part takes longer than the mean by more than kEven, borders move half
/// the way to where they would be if a part's work were even over its share. A part also works on what all parts do
/// (base/share.hpp), which moving borders does not change; so a step never goes too far.
class ShareBalance {
 public:
  static constexpr double kEven = 0.03, kDamping = 0.5;
  static constexpr double kLeast = 1.0 / 64;  ///< of an equal share; a part is never without one

  explicit ShareBalance(size_t parts) : times_(parts) {
    for (size_t k = 0; k <= parts; ++k) borders_.push_back(static_cast<double>(k) / static_cast<double>(parts));
  }

  size_t parts() const { return times_.size(); }
  /// Of the whole, in [0, 1].
  double size(size_t part) const { return borders_[part + 1] - borders_[part]; }
  ShareRange range(size_t part) const { return {number(borders_[part]), number(borders_[part + 1])}; }

  /// What a frame took each part; one that is like the next ones to come.
  void observe(std::span<const double> milliseconds) {
    for (size_t k = 0; k < parts(); ++k) times_[k].push(milliseconds[k]);
    if (!times_[0].is_full()) return;
    std::vector<double> work;
    double sum = 0;
    for (LastTimes& times : times_) sum += work.emplace_back(times.median());
    const double mean = sum / static_cast<double>(parts());
    if (*std::max_element(work.begin(), work.end()) <= (1 + kEven) * mean) return;
    move(work, mean);
    for (LastTimes& times : times_) times.clear();
  }

 private:
  static uint64_t number(double border) {
    return static_cast<uint64_t>(border * static_cast<double>(ShareRange::kAll));
  }

  /// Each inner border goes towards the place that as much work is before as there is in so many means.
  void move(const std::vector<double>& work, double mean) {
    std::vector<double> moved = borders_;
    double before = 0;
    size_t part = 0;
    for (size_t k = 1; k < parts(); ++k) {
      const double wanted = static_cast<double>(k) * mean;
      while (part + 1 < parts() && before + work[part] < wanted) before += work[part++];
      const double within = work[part] > 0 ? std::min((wanted - before) / work[part], 1.0) : 0;
      moved[k] += kDamping * (borders_[part] + within * size(part) - borders_[k]);
    }
    keep_apart(moved);
    borders_ = std::move(moved);
  }
  void keep_apart(std::vector<double>& borders) const {
    const double least = kLeast / static_cast<double>(parts());
    for (size_t k = 1; k < parts(); ++k) borders[k] = std::max(borders[k], borders[k - 1] + least);
    for (size_t k = parts() - 1; k > 0; --k) borders[k] = std::min(borders[k], borders[k + 1] - least);
  }

  std::vector<double> borders_;   ///< of the parts: one more than they are, from 0 to 1
  std::vector<LastTimes> times_;  ///< of each part since borders moved
};

}  // namespace collided
