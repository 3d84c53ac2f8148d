// The linear bounding volume hierarchy: the tree, its ropes, and the pairs that its walks find.

#include "gpu/engines/lbvh/lbvh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include "gpu/exec/cpu/cpu_exec.hpp"
#include "gpu/search/cpu/tree_walk.hpp"

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
  std::vector<MeshesTogether> meshes;  ///< below each node, where branches were given
  Box<float> bounds{{-1, -1, -1}, {2, 2, 2}};
  uint64_t extents = 0;
  CpuExec exec{2, 0};

  explicit TestHierarchy(std::vector<Box<float>> of, int axis_bits = MortonKeys::kMaxAxisBits,
                         const std::optional<BvhBranches>& branches = {})
      : boxes(std::move(of)),
        keys(boxes.size()),
        other_keys(boxes.size()),
        triangles(boxes.size()),
        other_triangles(boxes.size()),
        meeting(boxes.size()),
        nodes(2 * boxes.size() - 2),
        meshes(branches ? nodes.size() : 0) {
    for (const Box<float>& box : boxes) extents += extent_of(box, bounds);
    const MortonKeys codes{&bounds,
                           {&bounds, &extents, boxes.size()},
                           span_of(boxes),
                           span_of(keys),
                           span_of(triangles),
                           span_of(meeting),
                           axis_bits,
                           branches.value_or(BvhBranches{})};
    exec.for_each("keys", boxes.size(), codes);
    if (exec.sort_pairs("sort", codes.bits(),
                        {span_of(keys), span_of(other_keys), span_of(triangles), span_of(other_triangles)}) == 1) {
      keys.swap(other_keys);
      triangles.swap(other_triangles);
    }
    exec.for_each("build", boxes.size(),
                  BuildHierarchy{{span_of(keys), leaves()},
                                 span_of(triangles),
                                 span_of(boxes),
                                 span_of(meeting),
                                 span_of(nodes),
                                 codes.branches.filter,
                                 span_of(meshes)});
  }
  BvhPairs source(const PairFilter& filter) const {
    return {{nodes.data(), nodes.size()}, leaves(), filter, nullptr, 0, {meshes.data(), meshes.size()}};
  }
  uint32_t leaves() const { return static_cast<uint32_t>(boxes.size()); }
};

bool contains(const Box<float>& outer, const Box<float>& inner) {
  return outer.lo.x <= inner.lo.x && outer.lo.y <= inner.lo.y && outer.lo.z <= inner.lo.z && inner.hi.x <= outer.hi.x &&
         inner.hi.y <= outer.hi.y && inner.hi.z <= outer.hi.z;
}
bool same(const Box<float>& a, const Box<float>& b) { return contains(a, b) && contains(b, a); }

/// Leaves below a node in order; checks its box, and that its rope is `rope`.
void visit(const TestHierarchy& tree, uint32_t number, uint32_t rope, std::vector<uint32_t>& triangles) {
  ASSERT_LT(number, tree.nodes.size());
  const BvhNode& node = tree.nodes[number];
  EXPECT_EQ(node.rope, rope) << number;
  if (node.is_leaf()) {
    EXPECT_TRUE(same(node.box(), tree.boxes[node.triangle()]));
    return triangles.push_back(node.triangle());
  }
  ASSERT_LT(node.child + 1, tree.nodes.size());
  EXPECT_TRUE(same(node.box(), join(tree.nodes[node.child].box(), tree.nodes[node.child + 1].box())));
  visit(tree, node.child, node.child + 1, triangles);
  visit(tree, node.child + 1, rope, triangles);
}

/// The first of the right children that end with the last leaf.
uint32_t left_of_root(const TestHierarchy& tree) {
  uint32_t left = 0;
  while (tree.nodes[left + 1].rope != kNoNode) left += 2;
  return left;
}

void expect_tree(const TestHierarchy& tree) {
  std::vector<uint32_t> triangles = tree.triangles, visited, expected(tree.leaves());
  if (tree.leaves() > 1) {
    visit(tree, left_of_root(tree), left_of_root(tree) + 1, visited);
    visit(tree, left_of_root(tree) + 1, kNoNode, visited);
    EXPECT_EQ(visited, triangles) << "each leaf once, from left to right";
  }
  for (uint32_t i = 0; i < tree.leaves(); ++i) expected[i] = i;
  std::sort(triangles.begin(), triangles.end());
  EXPECT_EQ(triangles, expected) << "each triangle once";
  EXPECT_TRUE(std::is_sorted(tree.keys.begin(), tree.keys.end()));
}

using Pairs = std::multiset<std::pair<uint32_t, uint32_t>>;

/// What walks found, and how many boxes they met.
struct Found {
  Pairs pairs;
  uint64_t tests = 0;
};

Found walked_by_ropes(const TestHierarchy& tree, const BvhPairs& source) {
  Found found;
  for (uint32_t i = 0; i < tree.leaves(); ++i)
    found.tests += walk_item(source, i, [&](uint32_t a, uint32_t b) { found.pairs.insert(std::minmax(a, b)); });
  return found;
}

/// As the lanes of a warp do it: parts wait until some lane takes them. With room for few, others are walked alone.
Found walked_in_parts(const TestHierarchy& tree, const BvhPairs& source, size_t room) {
  Found found;
  for (uint32_t i = 0; i < tree.leaves(); ++i) {
    std::vector<BvhPairs::Part> waiting;
    const auto meet = [&](BvhPairs::Walk& walk, bool alone) {
      const BvhPairs::Met met = alone ? source.meet_one(walk) : source.meet(walk);
      for (uint32_t k = 0; k < 2; ++k)
        if ((met.partners >> k & 1u) != 0) found.pairs.insert(std::minmax(walk.triangle, met.found[k]));
      if (met.has_other()) waiting.push_back({walk.leaf, met.other});
      found.tests += met.tests;
    };
    for (BvhPairs::Walk walk = source.walk(i);;) {
      if (walk.is_over()) {
        if (waiting.empty()) break;
        walk = source.resume(waiting.back());
        waiting.pop_back();
      } else if (waiting.size() < room) {
        meet(walk, false);
      } else {
        const BvhPairs::Stretch stretch = source.stretch(walk);
        while (walk.node != stretch.end) meet(walk, true);
        walk.node = stretch.then;
      }
    }
  }
  return found;
}

void expect_pairs(const TestHierarchy& tree) {
  const BvhPairs source{{tree.nodes.data(), tree.nodes.size()}, tree.leaves(), {}, nullptr};
  const Found found = walked_by_ropes(tree, source);
  Pairs expected;
  for (uint32_t a = 0; a < tree.leaves(); ++a)
    for (uint32_t b = a + 1; b < tree.leaves(); ++b)
      if (overlap(tree.boxes[a], tree.boxes[b])) expected.insert({a, b});
  EXPECT_EQ(found.pairs, expected);
  EXPECT_GE(found.tests, found.pairs.size());
  for (size_t room : {1000, 2, 0}) {
    const Found in_parts = walked_in_parts(tree, source, room);
    EXPECT_EQ(in_parts.pairs, expected) << room;
    EXPECT_EQ(in_parts.tests, found.tests) << room;
  }
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
  for (int axis_bits : {1, 13, 15}) {
    const TestHierarchy tree(boxes, axis_bits);
    expect_tree(tree);
    expect_pairs(tree);
    const std::set<uint32_t> last(tree.triangles.end() - 2, tree.triangles.end());
    EXPECT_EQ(last, (std::set<uint32_t>{3, 77}));
  }
}

TEST(Lbvh, ObeysTheFilterOfMeshes) {
  const std::vector<uint32_t> mesh{0, 0, 1, 1, 2};
  const std::vector<MeshRule> rules{{1, 2, 0, 0}, {2, 1, 0, 0}, {4, ~0u, 0, 1}};
  const TestHierarchy tree(std::vector<Box<float>>(5, {{0, 0, 0}, {1, 1, 1}}));
  const BvhPairs source{{tree.nodes.data(), tree.nodes.size()}, 5, {mesh.data(), rules.data()}, nullptr};
  const Pairs expected{{0, 2}, {0, 3}, {1, 2}, {1, 3}};
  EXPECT_EQ(walked_by_ropes(tree, source).pairs, expected);
  EXPECT_EQ(walked_in_parts(tree, source, 1000).pairs, expected);
}

/// Pairs whose boxes meet, by their meshes, each once.
Pairs allowed_pairs(const std::vector<Box<float>>& boxes, const PairFilter& filter) {
  Pairs pairs;
  for (uint32_t a = 0; a < boxes.size(); ++a)
    for (uint32_t b = a + 1; b < boxes.size(); ++b)
      if (overlap(boxes[a], boxes[b]) && filter(a, b)) pairs.insert({a, b});
  return pairs;
}

void expect_walks(const TestHierarchy& tree, const PairFilter& filter, const Pairs& expected) {
  const BvhPairs source = tree.source(filter);
  const Found found = walked_by_ropes(tree, source);
  EXPECT_EQ(found.pairs, expected);
  for (size_t room : {1000, 2, 0}) EXPECT_EQ(walked_in_parts(tree, source, room).pairs, expected) << room;
}

// Branches change the order of the leaves, not the pairs: these are the ones that the rules let pass.
TEST(Lbvh, FindsTheSamePairsWithAnyBranches) {
  std::mt19937 random(11);
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  for (uint32_t run = 0; run < 60; ++run) {
    SCOPED_TRACE(run);
    const uint32_t meshes = 1 + below(12), bits = below(4);
    std::vector<MeshRule> rules(meshes);
    for (MeshRule& rule : rules) rule = {1u << below(3), below(8), below(2), below(2), below(1u << bits)};
    std::vector<uint32_t> mesh(20 + below(150));
    for (uint32_t& m : mesh) m = below(meshes);
    const PairFilter filter{mesh.data(), rules.data()};
    const auto boxes = random_boxes(static_cast<uint32_t>(mesh.size()), 0.5f, run);
    const TestHierarchy tree(boxes, 13, BvhBranches{filter, static_cast<int>(bits)});
    expect_tree(tree);
    expect_walks(tree, filter, allowed_pairs(boxes, filter));
  }
}

/// Probes in one place that may touch a few obstacles and nothing else. The obstacles are the last mesh.
struct Probes {
  static constexpr uint32_t kTriangles = 50, kObstacles = 40;

  Probes(uint32_t count, bool touch_themselves) {
    for (uint32_t p = 0; p < count; ++p) {
      rules.push_back({2, 1, 0, touch_themselves ? 1u : 0u, touch_themselves ? p : 0});
      const auto own = random_boxes(kTriangles, 0.2f, 12);
      boxes.insert(boxes.end(), own.begin(), own.end());
      mesh.insert(mesh.end(), kTriangles, p);
    }
    rules.push_back({1, ~0u, 1, 0, touch_themselves ? count : 1});
    const auto obstacles = random_boxes(kObstacles, 0.2f, 13);
    boxes.insert(boxes.end(), obstacles.begin(), obstacles.end());
    mesh.insert(mesh.end(), kObstacles, count);
  }
  PairFilter filter() const { return {mesh.data(), rules.data()}; }
  Found found(int branch_bits) const {
    const TestHierarchy tree(boxes, 13, BvhBranches{filter(), branch_bits});
    return walked_by_ropes(tree, tree.source(filter()));
  }

  std::vector<Box<float>> boxes;
  std::vector<MeshRule> rules;
  std::vector<uint32_t> mesh;
};

// A walk adds the way down to its own branch, which is the logarithm of the number of probes.
TEST(Lbvh, ProbesThatAreMaskedFromEachOtherCostWhatEachCostsAlone) {
  for (const bool touch_themselves : {false, true}) {
    SCOPED_TRACE(touch_themselves);
    const uint32_t count = 100;
    const Probes all(count, touch_themselves), one(1, touch_themselves);
    const Found of_all = all.found(7), of_one = one.found(1);
    EXPECT_EQ(of_all.pairs, allowed_pairs(all.boxes, all.filter()));
    EXPECT_EQ(of_all.pairs.size(), count * of_one.pairs.size());
    EXPECT_LT(of_all.tests, 3 * count * of_one.tests);
  }
}

}  // namespace
}  // namespace collided::test
