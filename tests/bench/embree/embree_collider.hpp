#pragma once
// Embree on the same problem as our broad phase: which boxes of a set overlap.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "client/cli/picture/embree.hpp"

namespace collided::test {

struct FloatBox {
  std::array<float, 3> lo, hi;
};

/// Closed boxes: those that touch overlap.
inline bool overlap(const FloatBox& a, const FloatBox& b) {
  return a.lo[0] <= b.hi[0] && b.lo[0] <= a.hi[0] && a.lo[1] <= b.hi[1] && b.lo[1] <= a.hi[1] && a.lo[2] <= b.hi[2] &&
         b.lo[2] <= a.hi[2];
}

/// One user geometry whose primitives are the boxes, which the caller keeps. Throws std::runtime_error.
class EmbreeCollider {
 public:
  /// RTC_BUILD_QUALITY_LOW sorts by Morton codes, MEDIUM is Embree's default, a binned surface area heuristic.
  EmbreeCollider(std::span<const FloatBox> boxes, RTCBuildQuality quality, int threads);
  ~EmbreeCollider();
  EmbreeCollider(const EmbreeCollider&) = delete;
  EmbreeCollider& operator=(const EmbreeCollider&) = delete;

  /// Rebuilds the hierarchy, in the memory of the last build.
  void build();
  /// How many pairs overlap, each counted once. Embree reports the pairs of leaves that overlap, in both orders; the
  /// boxes in them are compared here.
  uint64_t collide();
  /// The same of those pairs that `filter` accepts; it is called by several threads.
  uint64_t collide(const std::function<bool(uint32_t, uint32_t)>& filter);

 private:
  void check(const char* what) const;

  std::span<const FloatBox> boxes_;
  RTCDevice device_;
  RTCScene scene_;
  RTCGeometry geometry_;
};

}  // namespace collided::test
