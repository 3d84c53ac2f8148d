// The linear bounding volume hierarchy: the tree, its ropes, and the pairs that its walks find.

#include "gpu/broad/lbvh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "gpu/exec/cpu_exec.hpp"

namespace collided::test {
namespace {

template <class T>
Span<T> span_of(std::vector<T>& v) {
  return {v.data(), v.size()};
}

struct TestHierarchy {
  std::vector<Box<float>> boxes;
  std::vector<uint64_t> keys, other_keys;
  std::vector<uint32_t> triangles, other_triangles, meeting;
  std::vector<BvhNode> nodes;
  Box<float> bounds{{-1, -1, -1}, {2, 2, 2}};
  uint64_t extents = 0;
  CpuExec exec{2, 0};

  explicit TestHierarchy(std::vector<Box<float>> of)
      : boxes(std::move(of)),
        keys(boxes.size()),
        other_keys(boxes.size()),
        triangles(boxes.size()),
        other_triangles(boxes.size()),
        meeting(boxes.size()),
        nodes(2 * boxes.size() - 1) {
    for (const Box<float>& box : boxes) extents += extent_of(box, bounds);
    exec.for_each("keys", boxes.size(),
                  MortonKeys{&bounds,
                             {&bounds, &extents, boxes.size()},
                             span_of(boxes),
                             span_of(keys),
                             span_of(triangles),
                             span_of(meeting)});
    if (exec.sort_pairs("sort", MortonKeys::kBits,
                        {span_of(keys), span_of(other_keys), span_of(triangles), span_of(other_triangles)}) == 1) {
      keys.swap(other_keys);
      triangles.swap(other_triangles);
    }
    exec.for_each("build", boxes.size(),
                  BuildHierarchy{
                      {span_of(keys), leaves()}, span_of(triangles), span_of(boxes), span_of(meeting), span_of(nodes)});
  }
  uint32_t leaves() const { return static_cast<uint32_t>(boxes.size()); }
  bool is_leaf(uint32_t node) const { return node >= leaves() - 1; }
  /// The second child is where the rope of the first leads.
  uint32_t second_child(uint32_t node) const { return nodes[nodes[node].child].rope; }
};

bool contains(const Box<float>& outer, const Box<float>& inner) {
  return outer.lo.x <= inner.lo.x && outer.lo.y <= inner.lo.y && outer.lo.z <= inner.lo.z && inner.hi.x <= outer.hi.x &&
         inner.hi.y <= outer.hi.y && inner.hi.z <= outer.hi.z;
}
bool same(const Box<float>& a, const Box<float>& b) { return contains(a, b) && contains(b, a); }

/// Leaves below a node in order; checks its box, and that its rope is `rope`.
void visit(const TestHierarchy& tree, uint32_t node, uint32_t rope, std::vector<uint32_t>& leaves) {
  ASSERT_LT(node, tree.nodes.size());
  EXPECT_EQ(tree.nodes[node].rope, rope) << node;
  if (tree.is_leaf(node)) {
    EXPECT_TRUE(same(tree.nodes[node].box(), tree.boxes[tree.nodes[node].child]));
    return leaves.push_back(node - (tree.leaves() - 1));
  }
  const uint32_t first = tree.nodes[node].child, second = tree.second_child(node);
  ASSERT_LT(second, tree.nodes.size());
  EXPECT_TRUE(same(tree.nodes[node].box(), join(tree.nodes[first].box(), tree.nodes[second].box())));
  visit(tree, first, second, leaves);
  visit(tree, second, rope, leaves);
}

void expect_tree(const TestHierarchy& tree) {
  std::vector<uint32_t> leaves, expected(tree.leaves());
  visit(tree, 0, kNoNode, leaves);
  for (uint32_t i = 0; i < tree.leaves(); ++i) expected[i] = i;
  EXPECT_EQ(leaves, expected) << "each leaf once, from left to right";
  std::vector<uint32_t> triangles = tree.triangles;
  std::sort(triangles.begin(), triangles.end());
  EXPECT_EQ(triangles, expected) << "each triangle once";
  EXPECT_TRUE(std::is_sorted(tree.keys.begin(), tree.keys.end()));
}

using Pairs = std::multiset<std::pair<uint32_t, uint32_t>>;

void expect_pairs(const TestHierarchy& tree) {
  uint64_t tests = 0;
  const BvhPairs source{{tree.nodes.data(), tree.nodes.size()}, tree.leaves(), {}, &tests};
  Pairs found, expected;
  uint64_t steps = 0;
  for (uint32_t i = 0; i < tree.leaves(); ++i)
    steps += walk_item(source, i, [&](uint32_t a, uint32_t b) { found.insert(std::minmax(a, b)); });
  source.add_tests(steps);
  for (uint32_t a = 0; a < tree.leaves(); ++a)
    for (uint32_t b = a + 1; b < tree.leaves(); ++b)
      if (overlap(tree.boxes[a], tree.boxes[b])) expected.insert({a, b});
  EXPECT_EQ(found, expected);
  EXPECT_GE(tests, found.size());
}

std::vector<Box<float>> random_boxes(uint32_t count, float size, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(0, 1);
  std::vector<Box<float>> boxes;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3<float> lo{place(random), place(random), place(random)};
    const float side = size * place(random);
    boxes.push_back({lo, lo + Vec3<float>{side, side, side}});
  }
  return boxes;
}

void expect_right(std::vector<Box<float>> boxes) {
  const TestHierarchy tree(std::move(boxes));
  expect_tree(tree);
  expect_pairs(tree);
}

TEST(Lbvh, IsATreeOverAllLeavesForEverySmallNumber) {
  for (uint32_t count = 1; count <= 40; ++count) {
    SCOPED_TRACE(count);
    expect_right(random_boxes(count, 0.3f, count));
  }
}

TEST(Lbvh, IsATreeOverManyLeaves) {
  expect_right(random_boxes(3000, 0.1f, 7));
  for (int run = 0; run < 20; ++run) expect_tree(TestHierarchy(random_boxes(20000, 0.01f, 8)));
}

TEST(Lbvh, TellsEqualBoxesApart) {
  for (uint32_t count : {2u, 3u, 64u, 100u, 257u})
    expect_right(std::vector<Box<float>>(count, {{0.5f, 0.5f, 0.5f}, {0.75f, 0.75f, 0.75f}}));
  std::vector<Box<float>> pairs = random_boxes(200, 0.2f, 9);
  pairs.insert(pairs.end(), pairs.begin(), pairs.end());
  pairs.insert(pairs.end(), pairs.begin(), pairs.begin() + 50);
  expect_right(pairs);
}

TEST(Lbvh, PutsMuchLargerBoxesLast) {
  std::vector<Box<float>> boxes = random_boxes(500, 0.01f, 10);
  boxes[3] = {{0, 0, 0}, {1, 1, 1}};
  boxes[77] = {{0.2f, 0, 0}, {0.9f, 1, 1}};
  const TestHierarchy tree(boxes);
  expect_tree(tree);
  expect_pairs(tree);
  const std::set<uint32_t> last(tree.triangles.end() - 2, tree.triangles.end());
  EXPECT_EQ(last, (std::set<uint32_t>{3, 77}));
}

TEST(Lbvh, ObeysTheFilterOfMeshes) {
  const std::vector<uint32_t> mesh{0, 0, 1, 1, 2};
  const std::vector<MeshRule> rules{{1, 2, 0, 1}, {2, 1, 0, 0}, {4, ~0u, 0, 1}};
  const TestHierarchy tree(std::vector<Box<float>>(5, {{0, 0, 0}, {1, 1, 1}}));
  const BvhPairs source{{tree.nodes.data(), tree.nodes.size()}, 5, {mesh.data(), rules.data()}, nullptr};
  Pairs found;
  for (uint32_t i = 0; i < 5; ++i)
    walk_item(source, i, [&](uint32_t a, uint32_t b) { found.insert(std::minmax(a, b)); });
  EXPECT_EQ(found, (Pairs{{0, 2}, {0, 3}, {1, 2}, {1, 3}}));
}

}  // namespace
}  // namespace collided::test
