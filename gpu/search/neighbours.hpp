#pragma once
// Neighbours: pairs of features that may touch in the next few frames, as molecular dynamics lists them. Each vertex is
// expected to go on as it moved when they were listed (its track), and may be off by a margin. A frame is where the
// list expects it if every vertex begins and ends within the margin of its track, moves within half of it beside the
// track, and has no larger inflation than it had; then no pair is a contact that is not listed. Pairs that move alike
// keep apart for long, however fast they are.

#include <cmath>

#include "gpu/base/mesh_filter.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/search/elementary.hpp"

namespace collided {

/// A test of the triangles a < b, counted from the first of its kind (search/elementary_numbers.hpp), in one number.
struct PackedTest {
  static constexpr int kIdBits = 30;
  uint32_t a, b;
  int test;

  COLLIDED_HD uint64_t packed() const {
    return uint64_t{a} << kIdBits | b | static_cast<uint64_t>(test) << (2 * kIdBits);
  }
  COLLIDED_HD static PackedTest unpacked(uint64_t packed) {
    constexpr uint64_t kIdMask = (1u << kIdBits) - 1u;
    return {static_cast<uint32_t>(packed >> kIdBits & kIdMask), static_cast<uint32_t>(packed & kIdMask),
            static_cast<int>(packed >> (2 * kIdBits))};
  }
};

/// When a step's frame is on the tracks: in frames since the one whose end they begin at.
struct TrackTimes {
  double from, to;
  double margin;

  /// The frame in which they are made.
  COLLIDED_HD bool is_first() const { return to == 0; }
};

/// Where a vertex is expected, and what the boxes of its features were inflated by.
template <class Real>
struct alignas(16) Track {
  Vec3<Real> at;
  Real inflation;
  Vec3<Real> step;  ///< a frame's

  /// What is left of the margin by a path that begins at one time and ends at the other, rounded down.
  COLLIDED_HD double slack(const Vec3<Real>& begin, const Vec3<Real>& end, const TrackTimes& times) const {
    const Vec3<double> before = off(begin, times.from), after = off(end, times.to), change = after - before;
    const double most = max(4 * dot(change, change), max(dot(before, before), dot(after, after)));
    const double largest = max(largest_component(at), max(largest_component(begin), largest_component(end)));
    // Each of the few roundings is off by 2^-53 of what it rounds.
    const double doubt = 0x1p-48 * (largest + times.to * static_cast<double>(largest_component(step)));
    return times.margin - (std::sqrt(most) * (1 + 0x1p-48) + doubt);
  }

 private:
  COLLIDED_HD Vec3<double> off(const Vec3<Real>& p, double time) const {
    return {off(p.x, at.x, step.x, time), off(p.y, at.y, step.y, time), off(p.z, at.z, step.z, time)};
  }
  COLLIDED_HD static double off(Real p, Real at, Real step, double time) {
    return static_cast<double>(p) - (static_cast<double>(at) + time * static_cast<double>(step));
  }
};

/// Where vertices end after so many frames more like this one, rounded away from where they are: with where they begin
/// now it bounds all that their tracks pass through meanwhile.
template <class Real>
struct Extrapolate {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double frames;
  Vec3<Real>* out;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Vec3<Real> a = start[i], b = end[i];
    out[i] = {beyond(b.x, b.x - a.x), beyond(b.y, b.y - a.y), beyond(b.z, b.z - a.z)};
  }

 private:
  COLLIDED_HD Real beyond(Real at, Real step) const {
    if (step == 0) return at;
    const double there = static_cast<double>(at) + frames * static_cast<double>(step);
    if (step > 0) return next_up(static_cast<Real>(next_up(next_up(there))));
    return next_down(static_cast<Real>(next_down(next_down(there))));
  }
};

/// What a search wrote.
struct Neighbours {
  Span<const uint64_t> first, second;  ///< PackedTest, of vertices and triangles, and of edges
  const uint64_t* counts;              ///< of both
  const double* slack;                 ///< Displacement::slack of the step

  /// The lists do not hold all that may touch.
  COLLIDED_HD bool must_rerun() const { return *slack < 0 || counts[0] > first.size() || counts[1] > second.size(); }
  COLLIDED_HD uint64_t size(int kind) const { return must_rerun() ? 0 : counts[kind]; }
};

/// Tracks begin at the end of this frame.
template <class Tests>
struct BeginTracks {
  using Real = typename Tests::Number;
  Tests tests;
  Span<Track<Real>> tracks;  ///< of each vertex that an element has

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint32_t triangle = static_cast<uint32_t>(i), own = tests.owned[i];
    for (int k = 0; k < 3; ++k) {
      if ((own >> k & 1u) == 0) continue;
      const CornerRecord<Real> corner = tests.records[i].corner[k];
      const Path<Real> path = tests.records.path(corner, corner.vertex);
      tracks[corner.vertex] = {path.end, tests.inflation.of(triangle), path.end - path.start};
    }
  }
};

/// What a step with lists looks at all triangles for.
struct Displacement {
  static constexpr double kNone = -0x1p1023;

  Box<float> bounds;
  double slack;  ///< of the margin, what no vertex has used; < 0: one has left it; kNone: nobody can tell how far
  double moved;  ///< the longest way of a vertex along an axis
};

struct JoinDisplacements {
  COLLIDED_HD Displacement operator()(const Displacement& a, const Displacement& b) const {
    return {join(a.bounds, b.bounds), min(a.slack, b.slack), max(a.moved, b.moved)};
  }
};

template <class Tests>
struct DisplacementOf {
  using Real = typename Tests::Number;
  Tests tests;
  Span<const Box<float>> boxes;
  Span<const Track<Real>> tracks;
  const TrackTimes* times;
  PairFilter idle;  ///< has rules where some meshes may touch nothing; these may leave their tracks

  COLLIDED_HD Displacement operator()(uint64_t i) const {
    Displacement all{boxes[i], times->margin, 0};
    if (idle.has_rules() && idle.is_idle(static_cast<uint32_t>(i))) return all;
    const uint32_t triangle = static_cast<uint32_t>(i), own = tests.owned[i];
    for (int k = 0; k < 3; ++k) {
      if ((own >> k & 1u) == 0) continue;
      const CornerRecord<Real> corner = tests.records[i].corner[k];
      const Path<Real> path = tests.records.path(corner, corner.vertex);
      all.moved = max(all.moved, static_cast<double>(largest_component(path.end - path.start)));
      if (!times->is_first()) all.slack = min(all.slack, slack_of(triangle, corner.vertex, path));
    }
    return all;
  }

 private:
  COLLIDED_HD double slack_of(uint32_t triangle, uint32_t vertex, const Path<Real>& path) const {
    const Track<Real> track = tracks[vertex];
    if (!(tests.inflation.of(triangle) <= track.inflation)) return Displacement::kNone;
    const double slack = track.slack(path.start, path.end, *times);
    return slack > Displacement::kNone ? slack : Displacement::kNone;
  }
};

}  // namespace collided
