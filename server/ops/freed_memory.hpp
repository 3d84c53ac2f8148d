#pragma once
// What was freed, back to the system: by itself the allocator keeps what many small pieces took, for each of its
// arenas.

#include <malloc.h>

#include <algorithm>
#include <cstddef>

namespace collided::server {

/// One thread at a time.
class FreedMemory {
 public:
  /// Does nothing unless much has been freed since the last time. Takes milliseconds where it does.
  void give_back() {
    const size_t free = mallinfo2().fordblks;  // with what was given back
    given_ = std::min(given_, free);
    if (free - given_ < kMuch) return;
    malloc_trim(0);
    given_ = free;
  }

 private:
  static constexpr size_t kMuch = size_t{16} << 20;

  size_t given_ = 0;  // bytes that are free, but the system's already
};

}  // namespace collided::server
