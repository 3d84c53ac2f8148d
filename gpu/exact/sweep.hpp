#pragma once
// Pairs of boxes that overlap, on the host.

#include <algorithm>
#include <vector>

#include "gpu/base/box.hpp"

namespace collided::exact {

struct NumberedBox {
  Box<double> box;
  uint32_t index;
};

inline Box<double> box_of_all(const std::vector<NumberedBox>& boxes) {
  Box<double> all = boxes.front().box;
  for (const NumberedBox& b : boxes) all = join(all, b.box);
  return all;
}
inline void keep_those_in(const Box<double>& box, std::vector<NumberedBox>& boxes) {
  std::erase_if(boxes, [&](const NumberedBox& b) { return !overlap(b.box, box); });
}

/// Calls use(i, j) for each box i of `first` and box j of `second` that overlap. It sweeps along the axis in which what
/// both have in common is longest: bodies that are flush on a plane have little else in common.
template <class Use>
void for_each_overlap(std::vector<NumberedBox> first, std::vector<NumberedBox> second, const Use& use) {
  if (first.empty() || second.empty()) return;
  keep_those_in(box_of_all(second), first);
  if (first.empty()) return;
  keep_those_in(box_of_all(first), second);
  if (second.empty()) return;
  const Box<double> a = box_of_all(first), b = box_of_all(second);
  const auto length = [&](double Vec3<double>::*axis) {
    return std::min(a.hi.*axis, b.hi.*axis) - std::max(a.lo.*axis, b.lo.*axis);
  };
  double Vec3<double>::*axis = &Vec3<double>::x;
  for (double Vec3<double>::*other : {&Vec3<double>::y, &Vec3<double>::z})
    if (length(other) > length(axis)) axis = other;
  const auto is_before = [&](const NumberedBox& l, const NumberedBox& r) { return l.box.lo.*axis < r.box.lo.*axis; };
  std::sort(first.begin(), first.end(), is_before);
  std::sort(second.begin(), second.end(), is_before);
  const auto scan = [&](const NumberedBox& from, const std::vector<NumberedBox>& others, size_t begin,
                        const auto& use_pair) {
    for (size_t k = begin; k < others.size() && others[k].box.lo.*axis <= from.box.hi.*axis; ++k)
      if (overlap(from.box, others[k].box)) use_pair(others[k].index);
  };
  for (size_t i = 0, j = 0; i < first.size() && j < second.size();)
    if (is_before(second[j], first[i])) {
      scan(second[j], first, i, [&](uint32_t other) { use(other, second[j].index); });
      ++j;
    } else {
      scan(first[i], second, j, [&](uint32_t other) { use(first[i].index, other); });
      ++i;
    }
}

}  // namespace collided::exact
