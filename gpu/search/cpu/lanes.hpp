#pragma once
// Four numbers at once on CPU cores, by the vector types of GCC and Clang: whatever vector unit there is. Nothing here
// rounds, so that the answers are those of one number after the other.

#include <cstdint>

#include "gpu/base/box.hpp"

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace collided {

namespace detail {
template <class T>
struct LanesOf {
  // No more aligned than what malloc gives.
  typedef T Type __attribute__((vector_size(4 * sizeof(T)), aligned(16)));
};
}  // namespace detail

/// Four numbers.
template <class T>
using Lanes = typename detail::LanesOf<T>::Type;

/// The same number in all lanes.
template <class T>
void fill_lanes(Lanes<T>& lanes, T x) {
  lanes = Lanes<T>{x, x, x, x};
}

/// Bit k: whether lane k of a comparison holds.
template <class Comparison>
inline uint32_t lane_bits(const Comparison& holds) {
#ifdef __SSE2__
  if constexpr (sizeof(holds) == sizeof(__m128))
    return static_cast<uint32_t>(_mm_movemask_ps(reinterpret_cast<const __m128&>(holds)));
  else
    return lane_bits(__builtin_convertvector(holds, Lanes<int32_t>));
#else
  uint32_t bits = 0;
  for (int k = 0; k < 4; ++k) bits |= static_cast<uint32_t>(holds[k]) & 1u << k;
  return bits;
#endif
}

/// Four boxes, axis by axis.
template <class Real>
struct BoxLanes {
  Lanes<Real> lo[3], hi[3];

  void set(int lane, const Box<Real>& box) {
    lo[0][lane] = box.lo.x, lo[1][lane] = box.lo.y, lo[2][lane] = box.lo.z;
    hi[0][lane] = box.hi.x, hi[1][lane] = box.hi.y, hi[2][lane] = box.hi.z;
  }
  Box<Real> get(int lane) const {
    return {{lo[0][lane], lo[1][lane], lo[2][lane]}, {hi[0][lane], hi[1][lane], hi[2][lane]}};
  }
  /// The box of one lane in all of them.
  BoxLanes spread(int lane) const {
    BoxLanes all;
    for (int axis = 0; axis < 3; ++axis) {
      fill_lanes<Real>(all.lo[axis], lo[axis][lane]);
      fill_lanes<Real>(all.hi[axis], hi[axis][lane]);
    }
    return all;
  }
};

/// Bit k: whether the boxes of lane k are not apart. Bounds that are not numbers keep nothing apart.
template <class Real>
uint32_t meeting_lanes(const BoxLanes<Real>& a, const BoxLanes<Real>& b) {
  const auto apart = (a.lo[0] > b.hi[0]) | (b.lo[0] > a.hi[0]) | (a.lo[1] > b.hi[1]) | (b.lo[1] > a.hi[1]) |
                     (a.lo[2] > b.hi[2]) | (b.lo[2] > a.hi[2]);
  return ~lane_bits(apart) & 0xfu;
}

}  // namespace collided
