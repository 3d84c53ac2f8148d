#pragma once
// A quota that is short of memory once.

#include "gpu/detector.hpp"

namespace collided::test {

/// Refuses the k-th take of memory.
class RefusingQuota final : public MemoryQuota {
 public:
  /// Counted from here, the first is 1; 0: none is refused.
  void refuse_at(int take) { left_ = take, has_refused_ = false; }
  bool has_refused() const { return has_refused_; }

  void take(uint64_t) override {
    if (left_ == 0 || --left_ > 0) return;
    has_refused_ = true;
    throw ResourceExhausted("the test's quota");
  }
  void give_back(uint64_t) noexcept override {}

 private:
  int left_ = 0;
  bool has_refused_ = false;
};

}  // namespace collided::test
