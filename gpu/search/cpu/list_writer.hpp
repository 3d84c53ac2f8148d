#pragma once
// Appending from CPU cores: a thread keeps what it found and appends it in blocks, one atomic for each.

#include <algorithm>

#include "gpu/exec/atomic.hpp"

namespace collided {

/// What one thread appends to a list; flush() after the last.
template <class T>
class ListWriter {
 public:
  explicit ListWriter(const AppendList<T>& list) : list_(list) {}

  void push(const T& value) {
    block_[size_++] = value;
    if (size_ == kBlock) flush();
  }
  void flush() {
    if (size_ == 0) return;
    const uint64_t first = atomic_add(*list_.count, uint64_t{size_});
    const uint64_t room = first < list_.items.size() ? list_.items.size() - first : 0;
    std::copy_n(block_, std::min<uint64_t>(size_, room), list_.items.data + first);
    size_ = 0;
  }

 private:
  static constexpr uint32_t kBlock = 512;

  AppendList<T> list_;
  uint32_t size_ = 0;
  T block_[kBlock];
};

}  // namespace collided
