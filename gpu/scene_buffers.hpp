#pragma once
// Everything that a scene keeps on its backend. Arrays of stages that the scene does not have stay empty.

#include "gpu/broad/boxes.hpp"
#include "gpu/broad/elementary.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/narrow/contact.hpp"
#include "gpu/octree/count.hpp"

namespace collided {

/// Topology, as resident arrays.
template <class Exec>
struct ResidentTopology {
  explicit ResidentTopology(Exec& exec)
      : triangles(exec, "triangles"),
        triangle_edges(exec, "edges"),
        edges(exec, "edges"),
        owned(exec, "ownership"),
        mesh_of_triangle(exec, "pair_filter"),
        rules(exec, "pair_filter") {}

  Buffer<Triangle, Exec> triangles;
  Buffer<Triangle, Exec> triangle_edges;
  Buffer<EdgePair, Exec> edges;
  Buffer<uint8_t, Exec> owned;
  Buffer<uint32_t, Exec> mesh_of_triangle;
  Buffer<MeshRule, Exec> rules;
};

/// The octree grid of one frame.
template <class Exec>
struct OctreeBuffers {
  explicit OctreeBuffers(Exec& exec)
      : units(exec, "octree"),
        counts(exec, "octree"),
        cost(exec, "octree"),
        type(exec, "octree"),
        slot(exec, "octree"),
        leaves(exec, "octree"),
        leaf_units(exec, "octree"),
        offsets(exec, "octree"),
        cursor(exec, "octree"),
        level_registrations(exec, "octree"),
        registered(exec, "registrations") {}

  Buffer<uint64_t, Exec> units;
  Buffer<uint32_t, Exec> counts;
  Buffer<uint64_t, Exec> cost;
  Buffer<uint8_t, Exec> type;
  Buffer<uint32_t, Exec> slot;
  Buffer<Leaf, Exec> leaves;
  Buffer<uint64_t, Exec> leaf_units;
  Buffer<uint64_t, Exec> offsets;
  Buffer<uint32_t, Exec> cursor;
  Buffer<uint64_t, Exec> level_registrations;
  Buffer<uint32_t, Exec> registered;
};

/// Contacts of one kind while they are found and sorted.
template <class Exec, class Real>
struct ContactBuffers {
  explicit ContactBuffers(Exec& exec)
      : keys(exec, "contacts"), data(exec, "contacts"), order(exec, "contacts"), sorted(exec, "contacts") {}

  Buffer<uint64_t, Exec> keys;
  Buffer<ContactData<Real>, Exec> data;
  Buffer<uint32_t, Exec> order;
  Buffer<ContactData<Real>, Exec> sorted;
};

template <class Exec, class Real>
struct SceneBuffers {
  explicit SceneBuffers(Exec& exec)
      : topology(exec),
        start(exec, "start_positions"),
        end(exec, "positions"),
        boxes(exec, "boxes"),
        octree(exec),
        pairs(exec, "pairs"),
        candidates(exec, "candidates"),
        survivors(exec, "candidates"),
        contacts(exec),
        earliest(exec),
        exact_keys(exec, "exact"),
        exact_points(exec, "exact"),
        shortcut(exec, "counters"),
        list_count(exec, "counters") {}

  ResidentTopology<Exec> topology;
  Buffer<Vec3<Real>, Exec> start;  ///< CCD only
  Buffer<Vec3<Real>, Exec> end;
  Buffer<Box<float>, Exec> boxes;
  OctreeBuffers<Exec> octree;
  Buffer<TrianglePair, Exec> pairs;
  Buffer<uint64_t, Exec> candidates;  ///< of one kind at a time
  Buffer<uint64_t, Exec> survivors;   ///< of the filter
  ContactBuffers<Exec, Real> contacts;
  ContactBuffers<Exec, Real> earliest;  ///< EARLIEST_ONLY
  Buffer<uint64_t, Exec> exact_keys;
  Buffer<Vec3<Real>, Exec> exact_points;
  Buffer<Shortcut, Exec> shortcut;
  Buffer<uint64_t, Exec> list_count;
};

}  // namespace collided
