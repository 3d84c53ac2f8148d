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
    malloc_trim(0);
    left_ = unused_bytes();
  }

 private:
  static constexpr double kThreshold = 8 << 20;

  /// Includes memory that never was the allocator's, such as stacks, which changes little.
  static double unused_bytes() {
    const auto used = mallinfo2();
    return process_private_bytes() - static_cast<double>(used.uordblks + used.hblkhd);
  }

  double left_ = unused_bytes();
};

}  // namespace collided::server
