#pragma once
// Contacts and their vertices brought together.

#include "gpu/base/half_thickness.hpp"
#include "gpu/base/worlds.hpp"
#include "gpu/contacts/kinds.hpp"
#include "gpu/narrow/triangle_pairs.hpp"

namespace collided {

/// Contacts that are not later than the earliest one that counts.
template <class Real>
struct KeepEarliest {
  Span<const uint64_t> keys;
  Span<const ContactData<Real>> data;
  const Shortcut* shortcut;
  ContactList<Real> kept;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (detail::bit_copy<uint64_t>(data[i].toi) <= shortcut->earliest_bits) kept.push(keys[i], data[i]);
  }
};

/// The four vertices of each candidate at t = 0, then at t = 1.
template <class Real, class Kind>
struct GatherPoints {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  Kind kind;
  Span<const uint64_t> candidates;
  Span<Vec3<Real>> points;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Stencil s = kind.stencil(candidates[i]);
    for (int k = 0; k < 4; ++k) {
      points[8 * i + k] = start[s.v[k]];
      points[8 * i + 4 + k] = end[s.v[k]];
    }
  }
};

/// The ids of the four vertices of each candidate.
template <class Kind>
struct GatherStencils {
  Kind kind;
  Span<const uint64_t> candidates;
  Span<uint32_t> ids;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Stencil s = kind.stencil(candidates[i]);
    for (int k = 0; k < 4; ++k) ids[4 * i + k] = s.v[k];
  }
};

/// The half thicknesses of each candidate's two meshes.
template <class Kind>
struct GatherHalves {
  HalfThicknesses halves;
  Kind kind;
  Span<const uint64_t> candidates;
  Span<PairHalves> out;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Stencil s = kind.stencil(candidates[i]);
    out[i] = {halves.of(s.v[0]), halves.of(s.v[3])};
  }
};

/// The corners of the first triangle of each pair, then of the second. A common corner comes first in both.
template <class Real>
struct GatherCorners {
  const Vec3<Real>* positions;
  WorldTable<Vec3<uint32_t>> triangles;
  Span<const uint64_t> pairs;
  Span<Vec3<Real>> points;
  Span<uint32_t> common;  ///< 1 if there is such a corner, else 0

  COLLIDED_HD void operator()(uint64_t i) const {
    Vec3<uint32_t> a = triangles[pairs[i] >> 32], b = triangles[static_cast<uint32_t>(pairs[i])];
    common[i] = turn_to_common_corner(a, b) ? 1 : 0;
    const uint32_t v[6] = {a.x, a.y, a.z, b.x, b.y, b.z};
    for (int k = 0; k < 6; ++k) points[6 * i + k] = positions[v[k]];
  }
};

/// The ends of the edge of each pair, then the corners of the triangle: their ids, and where they are.
template <class Real>
struct GatherEdgeTriangles {
  const Vec3<Real>* positions;
  WorldTable<EdgePair> edges;
  WorldTable<Vec3<uint32_t>> triangles;
  Span<const uint64_t> pairs;
  Span<Vec3<Real>> points;
  Span<uint32_t> ids;

  COLLIDED_HD void operator()(uint64_t i) const {
    const EdgePair e = edges[pairs[i] >> 32];
    const Vec3<uint32_t> t = triangles[static_cast<uint32_t>(pairs[i])];
    const uint32_t v[5] = {e.from, e.to, t.x, t.y, t.z};
    for (int k = 0; k < 5; ++k) points[5 * i + k] = positions[v[k]], ids[5 * i + k] = v[k];
  }
};

}  // namespace collided
