#pragma once
// A frame's positions as they lie on the backend before the scene takes them: whether they can be, and where they go.

#include <algorithm>
#include <cmath>

#include "gpu/base/worlds.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/positions/quantized.hpp"

namespace collided {

/// New positions of one mesh.
struct PositionRun {
  uint64_t first;           ///< number of its first one among all of the frame's
  uint32_t first_vertex;    ///< of the mesh in the scene
  uint32_t vertex_count;    ///< of the mesh
  const uint32_t* indices;  ///< in the mesh; null: all vertices in order
  const std::byte* start;   ///< in the format that they came in; null: not given
  const std::byte* end;
  uint32_t world;  ///< 0 of a scene that is one
};

/// Those of a frame. At least one run if there are any positions.
template <class Real>
struct PositionRuns {
  Span<const PositionRun> runs;
  uint64_t count = 0;  ///< positions
  Quantization quantization = {};

  /// The k-th of those that came.
  COLLIDED_HD Vec3<Real> at(const std::byte* came, uint64_t k) const {
    return quantization.is_on ? convert<Real>(quantization.decode(reinterpret_cast<const Vec3<uint16_t>*>(came)[k]))
                              : reinterpret_cast<const Vec3<Real>*>(came)[k];
  }

  /// The run that holds position i.
  COLLIDED_HD uint64_t run_of(uint64_t i) const {
    uint64_t low = 0, high = runs.size();
    while (high - low > 1) {
      const uint64_t middle = (low + high) / 2;
      (runs[middle].first <= i ? low : high) = middle;
    }
    return low;
  }
};

/// What is wrong with a position; the lowest is the first.
struct BadPosition {
  enum What : uint64_t { kIndex, kEnd, kStart };
  uint64_t position;
  What what;
  uint32_t coordinate;

  COLLIDED_HD uint64_t packed() const { return position << 4 | what << 2 | coordinate; }
  static BadPosition of(uint64_t packed) {
    return {packed >> 4, static_cast<What>(packed >> 2 & 3), static_cast<uint32_t>(packed & 3)};
  }
};

/// Whether all numbers are within [-limit, limit]; NaN is not.
template <class Real>
bool are_within(const Real* values, uint64_t count, Real limit) {
  constexpr uint64_t kBlock = 4096;
  for (uint64_t block = 0; block < count; block += kBlock) {
    const uint64_t end = std::min(count, block + kBlock);
    unsigned bad = 0;
    for (uint64_t i = block; i < end; ++i) bad |= !(std::abs(values[i]) <= limit);
    if (bad != 0) return false;
  }
  return true;
}

/// Whether indices ascend strictly and the last is below `limit`.
inline bool are_ascending(const uint32_t* indices, uint64_t count, uint32_t limit) {
  unsigned bad = 0;
  for (uint64_t i = 1; i < count; ++i) bad |= indices[i - 1] >= indices[i];
  return bad == 0 && (count == 0 || indices[count - 1] < limit);
}

/// Finds the first position of each world that cannot be taken.
template <class Real>
struct CheckPositions {
  PositionRuns<Real> positions;
  Real limit;

  COLLIDED_HD void operator()(uint64_t i, uint64_t* first_bad_of_worlds) const {
    const PositionRun& run = positions.runs[positions.run_of(i)];
    uint64_t& first_bad = first_bad_of_worlds[run.world];
    const uint64_t k = i - run.first;
    if (run.indices != nullptr && !is_index_good(run, k))
      atomic_min(first_bad, BadPosition{i, BadPosition::kIndex, 0}.packed());
    check_point(positions.at(run.end, k), i, BadPosition::kEnd, first_bad);
    if (run.start != nullptr) check_point(positions.at(run.start, k), i, BadPosition::kStart, first_bad);
  }

  /// The same at once, on the host.
  bool is_clean() const {
    for (uint64_t r = 0; r < positions.runs.size(); ++r) {
      const PositionRun& run = positions.runs[r];
      const uint64_t count =
          (r + 1 < positions.runs.size() ? positions.runs[r + 1].first : positions.count) - run.first;
      if (run.indices != nullptr && !are_ascending(run.indices, count, run.vertex_count)) return false;
      if (count != 0 && !is_clean(run.end, count)) return false;
      if (count != 0 && run.start != nullptr && !is_clean(run.start, count)) return false;
    }
    return true;
  }

 private:
  /// Whatever is encoded is in the box.
  bool is_clean(const std::byte* came, uint64_t count) const {
    return positions.quantization.is_on || are_within(reinterpret_cast<const Real*>(came), 3 * count, limit);
  }
  COLLIDED_HD static bool is_index_good(const PositionRun& run, uint64_t k) {
    return run.indices[k] < run.vertex_count && (k == 0 || run.indices[k - 1] < run.indices[k]);
  }
  COLLIDED_HD void check_point(const Vec3<Real>& p, uint64_t i, BadPosition::What what, uint64_t& first_bad) const {
    const Real coordinates[3] = {p.x, p.y, p.z};
    for (uint32_t c = 0; c < 3; ++c)
      if (!(std::abs(coordinates[c]) <= limit)) atomic_min(first_bad, BadPosition{i, what, c}.packed());
  }
};

/// Puts positions where the scene has them.
template <class Real>
struct PlacePositions {
  PositionRuns<Real> positions;
  Vec3<Real>* start;  ///< null: not wanted
  Vec3<Real>* end;
  bool start_is_end;     ///< where no start is given; else the scene's stays
  const uint8_t* frame;  ///< what it does with each world (kStepsWorld); null: the scene is one

  COLLIDED_HD void operator()(uint64_t i) const {
    const PositionRun& run = positions.runs[positions.run_of(i)];
    const uint8_t does = frame != nullptr ? frame[run.world] : kStepsWorld;
    if ((does & kStepsWorld) == 0) return;
    const uint64_t k = i - run.first;
    const uint64_t vertex = run.first_vertex + (run.indices != nullptr ? run.indices[k] : k);
    const Vec3<Real> now = positions.at(run.end, k);
    end[vertex] = now;
    const bool follows_end = start_is_end || (does & kIsFirstOfWorld) != 0;
    if (start != nullptr && (run.start != nullptr || follows_end))
      start[vertex] = run.start != nullptr ? positions.at(run.start, k) : now;
  }
};

}  // namespace collided
