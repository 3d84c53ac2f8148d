#pragma once
// The search for pairs of triangles, on a backend: a source finds them, a sink takes them.

#include "gpu/exec/concepts.hpp"

namespace collided {

/// Of one scene. Each backend has its own, with the same two verbs:
/// - search(name, items, next, source, sink): the pairs of a source's items, member against member
/// (engines/octree/leaf_pairs.hpp);
/// - walk(name, items, next, source, sink): the pairs that the walks of a source's items find (engines/lbvh/lbvh.hpp).
/// - release(): gives back what it holds between them.
/// `next` is a zeroed counter on the backend.
template <Executor Exec>
class Searcher;

}  // namespace collided
