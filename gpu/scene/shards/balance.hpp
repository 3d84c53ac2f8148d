#pragma once
// How large the share of each shard of a scene is: shards are to take equally long.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/base/share.hpp"
#include "gpu/step/plan/trials.hpp"

namespace collided {

/// Shares are equal at first. Where the slowest shard takes longer than the mean by more than kEven, borders move half
/// the way to where they would be if a shard's work were even over its share. A shard also works on what all shards do
/// (base/share.hpp), which moving borders does not change; so a step never goes too far.
class ShareBalance {
 public:
  static constexpr double kEven = 0.03, kDamping = 0.5;
  static constexpr double kLeast = 1.0 / 64;  ///< of an equal share; a shard is never without one

  explicit ShareBalance(size_t shards) : times_(shards) {
    for (size_t k = 0; k <= shards; ++k) borders_.push_back(static_cast<double>(k) / static_cast<double>(shards));
  }

  size_t shards() const { return times_.size(); }
  /// Of the whole, in [0, 1].
  double size(size_t shard) const { return borders_[shard + 1] - borders_[shard]; }
  ShareRange range(size_t shard) const { return {number(borders_[shard]), number(borders_[shard + 1])}; }

  /// What a frame took each shard; one that is like the next ones to come.
  void observe(std::span<const double> milliseconds) {
    for (size_t k = 0; k < shards(); ++k) times_[k].push(milliseconds[k]);
    if (!times_[0].is_full()) return;
    std::vector<double> work;
    double sum = 0;
    for (LastTimes& times : times_) sum += work.emplace_back(times.median());
    const double mean = sum / static_cast<double>(shards());
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
    size_t shard = 0;
    for (size_t k = 1; k < shards(); ++k) {
      const double wanted = static_cast<double>(k) * mean;
      while (shard + 1 < shards() && before + work[shard] < wanted) before += work[shard++];
      const double within = work[shard] > 0 ? std::min((wanted - before) / work[shard], 1.0) : 0;
      moved[k] += kDamping * (borders_[shard] + within * size(shard) - borders_[k]);
    }
    keep_apart(moved);
    borders_ = std::move(moved);
  }
  void keep_apart(std::vector<double>& borders) const {
    const double least = kLeast / static_cast<double>(shards());
    for (size_t k = 1; k < shards(); ++k) borders[k] = std::max(borders[k], borders[k - 1] + least);
    for (size_t k = shards() - 1; k > 0; --k) borders[k] = std::min(borders[k], borders[k + 1] - least);
  }

  std::vector<double> borders_;   ///< of the shards: one more than they are, from 0 to 1
  std::vector<LastTimes> times_;  ///< of each shard since borders moved
};

}  // namespace collided
