#pragma once
// Returns freed memory to the system: on its own the allocator keeps the memory of many small allocations, in each of
// its arenas.

#include <malloc.h>

#include <algorithm>

#include "server/ops/process.hpp"

namespace collided::server {

/// One thread at a time.
class FreedMemory {
 public:
  /// Does nothing unless much more resident memory is unused than was left last time. Takes milliseconds when it trims.
  void give_back() {
    left_ = std::min(left_, unused_bytes());
    if (unused_bytes() - left_ < kThreshold) return;
    const double used = used_bytes();
    malloc_trim(0);
    // What another thread freed since is not left for good: it may have come too late to be returned. Asked in this
    // order, so that all of it is in both numbers.
    const double unused = unused_bytes();
    left_ = unused - std::max(0.0, used - used_bytes());
  }

 private:
  static constexpr double kThreshold = 8 << 20;

  static double used_bytes() {
    const auto used = mallinfo2();
    return static_cast<double>(used.uordblks + used.hblkhd);
  }
  /// Includes memory that never was the allocator's, such as stacks, which changes little.
  static double unused_bytes() { return process_private_bytes() - used_bytes(); }

  double left_ = unused_bytes();
};

}  // namespace collided::server
