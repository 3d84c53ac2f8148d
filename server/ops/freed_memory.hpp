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
  /// Does nothing unless much more resident memory is unused than a trim leaves. Takes milliseconds when it trims.
  void give_back() {
    const double used = used_bytes(), resident = process_private_bytes();
    left_ = std::min(left_, resident - used);
    if (resident - used - left_ < kThreshold) return;
    malloc_trim(0);
    // Only a trim that finds nothing tells what stays: beside one that returned much, or while others freed much, more may
    // have been freed too late to be returned. Then the next call trims again.
    const double used_now = used_bytes(), resident_now = process_private_bytes();
    if (resident - resident_now < kThreshold && used - used_now < kThreshold) left_ = resident_now - used_now;
  }

 private:
  static constexpr double kThreshold = 8 << 20;

  static double used_bytes() {
    const auto used = mallinfo2();
    return static_cast<double>(used.uordblks + used.hblkhd);
  }
  /// Includes memory that never was the allocator's, such as stacks, which changes little.
  static double unused_bytes() { return process_private_bytes() - used_bytes(); }

  double left_ = unused_bytes();  ///< what a trim does not return
};

}  // namespace collided::server
