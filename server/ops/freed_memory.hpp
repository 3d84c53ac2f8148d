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
  /// Does nothing unless much was freed since the last trim, or much more is resident and unused than it left. Takes
  /// milliseconds when it trims.
  void give_back() {
    const double used = process_heap_bytes(), unused = unused_bytes();
    most_used_ = std::max(most_used_, used);
    left_ = std::min(left_, unused);
    if (most_used_ - used < kThreshold && unused - left_ < kThreshold) return;
    malloc_trim(0);
    most_used_ = used;  // of before: what others freed since may have come too late to be returned
    left_ = unused_bytes();
  }

 private:
  static constexpr double kThreshold = 8 << 20;

  /// Includes memory that never was the allocator's, such as stacks.
  static double unused_bytes() {
    const double resident = process_private_bytes();
    return resident - process_heap_bytes();
  }

  double most_used_ = process_heap_bytes();  ///< since the last trim
  double left_ = unused_bytes();             ///< by the last trim, or less
};

}  // namespace collided::server
