#pragma once
// A quota that tells what a scene holds.

#include <algorithm>

#include "gpu/detector.hpp"

namespace collided::test {

/// Lets the scene take up to `most` bytes.
class CountedQuota final : public MemoryQuota {
 public:
  explicit CountedQuota(uint64_t most = ~uint64_t{0}) : most_(most) {}

  void take(uint64_t bytes) override {
    if (bytes > most_ - std::min(most_, held_)) throw ResourceExhausted("the quota is used up");
    held_ += bytes;
    peak_ = std::max(peak_, held_);
  }
  void give_back(uint64_t bytes) noexcept override { held_ -= bytes; }

  uint64_t held() const { return held_; }
  uint64_t peak() const { return peak_; }
  void set_most(uint64_t most) { most_ = most; }

 private:
  uint64_t most_, held_ = 0, peak_ = 0;
};

}  // namespace collided::test
