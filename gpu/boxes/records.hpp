#pragma once
// What a step keeps of each triangle for the tests of its features, in one place: reading it takes a few wide loads,
// where looking it up would take many scattered ones. Of positions in double it keeps the boxes that are tested,
// rounded outward to float, so that tests read no more than they do in float. That leaves few of them in doubt
// (surely_overlap); what these and the level's filter ask for is kept once for each vertex.

#include "gpu/base/box.hpp"
#include "gpu/contacts/contact.hpp"

namespace collided {

/// Whether the boxes in records are larger than those that make candidates.
template <class Real>
constexpr bool kRoundsBoxes = sizeof(Real) > sizeof(float);

/// Where a vertex begins and ends.
template <class Real>
struct alignas(16) Path {
  Vec3<Real> start, end;

  COLLIDED_HD Box<Real> swept() const { return join(Box<Real>{start, start}, Box<Real>{end, end}); }
};

/// A corner of a triangle: its path, and the edge from it to the next corner.
template <class Real>
struct alignas(16) CornerRecord {
  Vec3<Real> start;
  uint32_t vertex;
  alignas(16) Vec3<Real> end;
  uint32_t edge;

  COLLIDED_HD static CornerRecord of(const Path<Real>& path, Real, uint32_t vertex, uint32_t edge) {
    return {path.start, vertex, path.end, edge};
  }
  /// Of the path; and of the edge to another corner.
  COLLIDED_HD Box<float> box(Real inflation) const { return inflate(swept(), inflation); }
  COLLIDED_HD Box<float> box_to(const CornerRecord& other, Real inflation) const {
    return inflate(join(swept(), other.swept()), inflation);
  }

 private:
  COLLIDED_HD Box<Real> swept() const { return Path<Real>{start, end}.swept(); }
};
/// In double: the least float box that contains the inflated box of its path.
template <>
struct alignas(16) CornerRecord<double> {
  Vec3<float> lo;
  uint32_t vertex;
  alignas(16) Vec3<float> hi;
  uint32_t edge;

  COLLIDED_HD static CornerRecord of(const Path<double>& path, double inflation, uint32_t vertex, uint32_t edge) {
    const Box<float> box = outward_float(inflate(path.swept(), inflation));
    return {box.lo, vertex, box.hi, edge};
  }
  COLLIDED_HD Box<float> box(double) const { return {lo, hi}; }
  COLLIDED_HD Box<float> box_to(const CornerRecord& other, double) const { return join(box(0), other.box(0)); }
};

/// An edge's inflated box, and its vertices.
struct alignas(16) EdgeRecord {
  Vec3<float> lo;
  uint32_t from;
  alignas(16) Vec3<float> hi;
  uint32_t to;

  COLLIDED_HD Box<float> box() const { return {lo, hi}; }
};

template <class Real>
struct TriangleRecord {
  CornerRecord<Real> corner[3];
  EdgeRecord edge[3];  ///< from each corner to the next
};

/// Those of all triangles.
template <class Real>
struct TriangleRecords {
  Span<const TriangleRecord<Real>> records;
  Span<const Path<Real>> paths;  ///< of each vertex; empty where records have them

  COLLIDED_HD const TriangleRecord<Real>& operator[](uint64_t triangle) const { return records[triangle]; }
  /// Of a corner of one, which is at that vertex. By value: a record that is copied whole is read in two wide loads.
  COLLIDED_HD Path<Real> path(CornerRecord<Real> corner, uint32_t vertex) const {
    if constexpr (kRoundsBoxes<Real>)
      return paths[vertex];
    else
      return {corner.start, corner.end};
  }
};

/// Which of a pair's vertices its first feature has; the others are its second's.
enum class FirstFeature { kVertex = 1, kEdge = 2 };

/// The boxes of two features from the paths of their vertices, along one axis after the other: kept in registers at
/// once they would cost all that is around them.
template <FirstFeature kFirst, class Real>
struct BoxesOfPair {
  const Path<Real>* paths;
  Stencil stencil;
  Real inflation, inflation_of_second;

  COLLIDED_HD bool overlap() const {
    return overlap(&Vec3<Real>::x) && overlap(&Vec3<Real>::y) && overlap(&Vec3<Real>::z);
  }

 private:
  struct Range {
    Real lo, hi;
  };
  COLLIDED_HD bool overlap(Real Vec3<Real>::*axis) const {
    constexpr int kSecond = static_cast<int>(kFirst);
    const Range a = range(axis, 0, kSecond, inflation), b = range(axis, kSecond, 4, inflation_of_second);
    return a.lo <= b.hi && b.lo <= a.hi;
  }
  /// As inflate does it.
  COLLIDED_HD Range range(Real Vec3<Real>::*axis, int begin, int end, Real by) const {
    Range all = range(axis, stencil.v[begin]);
    for (int k = begin + 1; k < end; ++k) {
      const Range next = range(axis, stencil.v[k]);
      all = {min(all.lo, next.lo), max(all.hi, next.hi)};
    }
    return by == 0 ? all : Range{next_down(all.lo - by), next_up(all.hi + by)};
  }
  COLLIDED_HD Range range(Real Vec3<Real>::*axis, uint32_t vertex) const {
    const Real start = paths[vertex].start.*axis, end = paths[vertex].end.*axis;
    return {min(start, end), max(start, end)};
  }
};

}  // namespace collided
