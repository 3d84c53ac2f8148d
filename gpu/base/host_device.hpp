#pragma once
// What lets one source compile for CPU cores and for a GPU.

#include <cstddef>
#include <cstdint>
#include <type_traits>

#ifdef __CUDACC__
#define COLLIDED_HD __host__ __device__
#else
#define COLLIDED_HD
#endif

/// Keeps a function out of those that call it. Unrolled into each other, the loops of a GPU's code take minutes to
/// compile, and more registers than there are.
#ifdef __CUDACC__
#define COLLIDED_CALLED __noinline__
#else
#define COLLIDED_CALLED
#endif
/// The same on CPU cores, too: functions so long that a call costs them nothing.
#define COLLIDED_LONG [[gnu::noinline]]

namespace collided {

/// Borrowed array in the memory of the backend that works on it; owns nothing.
template <class T>
struct Span {
  T* data = nullptr;
  uint64_t count = 0;

  COLLIDED_HD T& operator[](uint64_t i) const { return data[i]; }
  COLLIDED_HD uint64_t size() const { return count; }
  COLLIDED_HD bool empty() const { return count == 0; }

  /// Anyone may read what one may write.
  template <class U, class = std::enable_if_t<std::is_same_v<U, const T> && !std::is_const_v<T>>>
  COLLIDED_HD operator Span<U>() const {
    return {data, count};
  }
};

}  // namespace collided
