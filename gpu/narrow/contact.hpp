#pragma once
// What the narrow phase writes, and how it reads a candidate's four vertices.

#include "gpu/detector.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/math/box.hpp"

namespace collided {

template <class Real>
struct ContactData {
  Real toi, distance;
  Real w0, w1;
  uint8_t flags;
};

/// Contacts in two lists that share their slots: keys to sort by, and the rest.
template <class Real>
struct ContactList {
  AppendList<uint64_t> keys;
  Span<ContactData<Real>> data;

  COLLIDED_HD void push(uint64_t key, const ContactData<Real>& contact) const {
    const uint64_t slot = claim_slot(*keys.count);
    if (slot >= keys.items.size()) return;
    keys.items[slot] = key;
    data[slot] = contact;
  }
};

/// Four vertex ids of a candidate.
struct Stencil {
  uint32_t v[4];
};

struct VertexTriangle {
  Span<const Vec3<uint32_t>> triangles;

  COLLIDED_HD Stencil stencil(uint64_t key) const {
    const Vec3<uint32_t> t = triangles[static_cast<uint32_t>(key)];
    return {{static_cast<uint32_t>(key >> 32), t.x, t.y, t.z}};
  }
};

struct EdgePair {
  uint32_t from, to;
};
struct EdgeEdge {
  Span<const EdgePair> edges;

  COLLIDED_HD Stencil stencil(uint64_t key) const {
    const EdgePair a = edges[key >> 32], b = edges[static_cast<uint32_t>(key)];
    return {{a.from, a.to, b.from, b.to}};
  }
};

}  // namespace collided
