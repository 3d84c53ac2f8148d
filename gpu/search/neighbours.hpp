#pragma once
// Neighbours, as molecular dynamics calls them: pairs of features whose boxes, widened by a margin, overlap. As long as
// the box of no vertex's path has left the widened box that it had when they were listed, they hold every candidate,
// whatever mode, thickness and deviations the boxes are of: a feature's box is the least that holds those of its
// vertices, and float boxes are rounded outward, both of which keep what holds what.

#include "gpu/exec/counted.hpp"
#include "gpu/search/elementary.hpp"

namespace collided {

/// A test of the triangles a < b, counted from the first of its kind (search/elementary_numbers.hpp), in one number.
struct PackedTest {
  static constexpr int kIdBits = 30;
  uint32_t a, b;
  int test;

  COLLIDED_HD uint64_t packed() const { return uint64_t{a} << kIdBits | b | static_cast<uint64_t>(test) << (2 * kIdBits); }
  COLLIDED_HD static PackedTest unpacked(uint64_t packed) {
    constexpr uint64_t kIdMask = (1u << kIdBits) - 1u;
    return {static_cast<uint32_t>(packed >> kIdBits & kIdMask), static_cast<uint32_t>(packed & kIdMask),
            static_cast<int>(packed >> (2 * kIdBits))};
  }
};

/// What a search wrote.
struct Neighbours {
  Span<const uint64_t> first, second;  ///< PackedTest, of vertices and triangles, and of edges
  const uint64_t* counts;              ///< of both
  const double* slack;                 ///< Displacement::slack of the step

  /// The lists do not hold all candidates.
  COLLIDED_HD bool must_rerun() const {
    return *slack < 0 || counts[0] > first.size() || counts[1] > second.size();
  }
  COLLIDED_HD uint64_t size(int kind) const { return must_rerun() ? 0 : counts[kind]; }
};

/// Notes the widened boxes of all vertices' paths: `tests` has the widened inflation.
template <class Tests>
struct NoteWidened {
  using Real = typename Tests::Number;
  Tests tests;
  Span<Box<Real>> widened;  ///< of each vertex that an element has

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint32_t triangle = static_cast<uint32_t>(i), own = tests.owned[i];
    for (int k = 0; k < 3; ++k)
      if ((own >> k & 1u) != 0) widened[tests.records[i].corner[k].vertex_id()] = tests.corner_box(triangle, k);
  }
};

/// What a step with lists looks at all triangles for.
struct Displacement {
  Box<float> bounds;
  double slack;  ///< how far the box of any path may still move within its widened one; < 0: it has left that
};

struct JoinDisplacements {
  COLLIDED_HD Displacement operator()(const Displacement& a, const Displacement& b) const {
    return {join(a.bounds, b.bounds), min(a.slack, b.slack)};
  }
};

template <class Tests>
struct DisplacementOf {
  using Real = typename Tests::Number;
  Tests tests;
  Span<const Box<float>> boxes;
  Span<const Box<Real>> widened;

  COLLIDED_HD Displacement operator()(uint64_t i) const {
    const uint32_t own = tests.owned[i];
    Displacement all{boxes[i], std::numeric_limits<double>::infinity()};
    for (int k = 0; k < 3; ++k)
      if ((own >> k & 1u) != 0)
        all.slack = min(all.slack, slack_of(tests.corner_box(static_cast<uint32_t>(i), k),
                                            widened[tests.records[i].corner[k].vertex_id()]));
    return all;
  }

 private:
  /// Its sign is exact; boxes that reach infinity have no other.
  COLLIDED_HD static double slack_of(const Box<Real>& box, const Box<Real>& within) {
    const bool holds = within.lo.x <= box.lo.x && within.lo.y <= box.lo.y && within.lo.z <= box.lo.z &&
                       box.hi.x <= within.hi.x && box.hi.y <= within.hi.y && box.hi.z <= within.hi.z;
    const Vec3<Real> below = box.lo - within.lo, above = within.hi - box.hi;
    const double slack = static_cast<double>(
        min(min(min(below.x, below.y), below.z), min(min(above.x, above.y), above.z)));
    if (holds) return slack >= 0 ? slack : 0;
    return slack < 0 ? slack : -std::numeric_limits<double>::infinity();
  }
};

}  // namespace collided
