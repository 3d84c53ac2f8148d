#pragma once
// Numbers of the elementary tests of a pair of triangles a and b, which tell the features that a test takes:
// 0-2: corner of a, triangle b; 3-5: corner of b, triangle a; 6 + 4k + m: edge k of a, edge m of b.

#include "gpu/base/host_device.hpp"

namespace collided {

constexpr int kFirstEdgeEdge = 6;

COLLIDED_HD constexpr int edge_edge_test(int k, int m) { return kFirstEdgeEdge + 4 * k + m; }
/// Which edges of the two triangles a test of edges takes.
COLLIDED_HD constexpr int first_edge_of(int test) { return (test - kFirstEdgeEdge) >> 2; }
COLLIDED_HD constexpr int second_edge_of(int test) { return (test - kFirstEdgeEdge) & 3; }

/// The number of a test if its triangles change places.
COLLIDED_HD constexpr int test_of_swapped(int test) {
  if (test < kFirstEdgeEdge) return test < 3 ? test + 3 : test - 3;
  return edge_edge_test(second_edge_of(test), first_edge_of(test));
}

}  // namespace collided
