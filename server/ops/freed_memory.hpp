#pragma once
// Gives freed memory back to the system: by itself the allocator keeps the memory of many small pieces, in each of its
// arenas.

#include <malloc.h>

#include <algorithm>
#include <cstddef>

namespace collided::server {

/// One thread at a time.
class FreedMemory {
 public:
  /// Does nothing unless much has been freed since the last time. Takes milliseconds if it does.
  void give_back() {
    const size_t free = mallinfo2().fordblks;  // includes what was given back
    given_ = std::min(given_, free);
    if (free - given_ < kThreshold) return;
    malloc_trim(0);
    given_ = free;
  }

 private:
  static constexpr size_t kThreshold = size_t{16} << 20;

  size_t given_ = 0;  // free bytes that the system has already
};

}  // namespace collided::server
