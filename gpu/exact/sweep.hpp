#pragma once
// Pairs of boxes that overlap, on the host.

#include <algorithm>
#include <array>
#include <vector>

#include "gpu/base/vec3.hpp"

namespace collided::exact {

/// The closed box around some points.
struct Bounds {
  std::array<double, 3> lower, upper;

  explicit Bounds(const Vec3<double>& p) : lower{p.x, p.y, p.z}, upper(lower) {}
  void see(const Bounds& other) {
    for (size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], other.lower[axis]);
      upper[axis] = std::max(upper[axis], other.upper[axis]);
    }
  }
  double common_length(const Bounds& other, size_t axis) const {
    return std::min(upper[axis], other.upper[axis]) - std::max(lower[axis], other.lower[axis]);
  }
  bool overlaps(const Bounds& other) const {
    for (size_t axis = 0; axis < 3; ++axis)
      if (lower[axis] > other.upper[axis] || other.lower[axis] > upper[axis]) return false;
    return true;
  }
};

struct NumberedBounds {
  Bounds bounds;
  uint32_t index;
};

inline Bounds bounds_of_all(const std::vector<NumberedBounds>& all) {
  Bounds bounds = all.front().bounds;
  for (const NumberedBounds& b : all) bounds.see(b.bounds);
  return bounds;
}
inline void keep_those_in(const Bounds& bounds, std::vector<NumberedBounds>& all) {
  std::erase_if(all, [&](const NumberedBounds& b) { return !b.bounds.overlaps(bounds); });
}

/// Calls use(i, j) for each box i of `first` and box j of `second` that overlap. It sweeps along the axis in which what
/// both have in common is longest: bodies that are flush on a plane have little else in common.
template <class Use>
void for_each_overlap(std::vector<NumberedBounds> first, std::vector<NumberedBounds> second, const Use& use) {
  if (first.empty() || second.empty()) return;
  keep_those_in(bounds_of_all(second), first);
  if (first.empty()) return;
  keep_those_in(bounds_of_all(first), second);
  if (second.empty()) return;
  const Bounds a = bounds_of_all(first), b = bounds_of_all(second);
  size_t axis = 0;
  for (const size_t other : {1, 2})
    if (a.common_length(b, other) > a.common_length(b, axis)) axis = other;
  const auto is_before = [&](const NumberedBounds& l, const NumberedBounds& r) {
    return l.bounds.lower[axis] < r.bounds.lower[axis];
  };
  std::sort(first.begin(), first.end(), is_before);
  std::sort(second.begin(), second.end(), is_before);
  const auto scan = [&](const Bounds& from, const std::vector<NumberedBounds>& others, size_t begin,
                        const auto& use_other) {
    for (size_t k = begin; k < others.size() && others[k].bounds.lower[axis] <= from.upper[axis]; ++k)
      if (from.overlaps(others[k].bounds)) use_other(others[k].index);
  };
  for (size_t i = 0, j = 0; i < first.size() && j < second.size();)
    if (is_before(second[j], first[i])) {
      scan(second[j].bounds, first, i, [&](uint32_t other) { use(other, second[j].index); });
      ++j;
    } else {
      scan(first[i].bounds, second, j, [&](uint32_t other) { use(first[i].index, other); });
      ++i;
    }
}

}  // namespace collided::exact
