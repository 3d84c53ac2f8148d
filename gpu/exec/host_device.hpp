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

namespace collided {

/// Borrowed array in the memory of the backend that works on it; owns nothing.
template <class T>
struct Span {
  T* data = nullptr;
  uint64_t count = 0;

  COLLIDED_HD T& operator[](uint64_t i) const { return data[i]; }
  COLLIDED_HD uint64_t size() const { return count; }
  COLLIDED_HD bool empty() const { return count == 0; }
  COLLIDED_HD operator Span<const T>() const requires(!std::is_const_v<T>) { return {data, count}; }
};

}  // namespace collided
