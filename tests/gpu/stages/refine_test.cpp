// The octree below its dense levels: whatever is refined, and however short the lists are, the leaves find every pair
// once or say that they could not.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <tuple>

#include "tests/gpu/stages/octree_build.hpp"

namespace collided::test {
namespace {

using Boxes = std::vector<Box<float>>;

class RandomBoxes {
 public:
  explicit RandomBoxes(uint32_t seed) : random_(seed) {}

  /// `count` boxes of up to `size` within a cube.
  void add(int count, const Vec3<float>& corner, float side, float size) {
    for (int i = 0; i < count; ++i) {
      const Vec3<float> lo{corner.x + side * unit(), corner.y + side * unit(), corner.z + side * unit()};
      boxes.push_back({lo, {lo.x + size * unit(), lo.y + size * unit(), lo.z + size * unit()}});
    }
  }
  float unit() { return std::uniform_real_distribution<float>(0, 1)(random_); }

  Boxes boxes;

 private:
  std::mt19937 random_;
};

struct Family {
  const char* name;
  Boxes (*make)(uint32_t seed);
};
void PrintTo(const Family& family, std::ostream* out) { *out << family.name; }

Boxes clusters_in_clusters(uint32_t seed) {
  RandomBoxes r(seed);
  for (const float side : {1e3f, 10.0f, 0.1f, 2e-3f}) r.add(250, {5, 5, 5}, side, side / 10);
  return r.boxes;
}
Boxes clusters_apart(uint32_t seed) {
  RandomBoxes r(seed);
  for (int i = 0; i < 6; ++i) r.add(150, {100 * r.unit(), 100 * r.unit(), 100 * r.unit()}, 0.3f, 0.05f * r.unit());
  return r.boxes;
}
Boxes clusters_under_huge_boxes(uint32_t seed) {
  RandomBoxes r(seed);
  r.add(500, {20, 20, 20}, 0.5f, 0.04f);
  r.add(40, {0, 0, 0}, 1, 100);
  r.add(100, {0, 0, 0}, 100, 10);
  return r.boxes;
}
Boxes in_one_point(uint32_t seed) {
  RandomBoxes r(seed);
  r.add(300, {1, 1, 1}, 0, 0);
  r.add(40, {0, 0, 0}, 3, 0.1f);
  return r.boxes;
}
// Corners on the borders of cells of all levels.
Boxes on_borders(uint32_t seed) {
  RandomBoxes r(seed);
  r.boxes = {{{0, 0, 0}, {0, 0, 0}}, {{64, 64, 64}, {64, 64, 64}}};
  const auto border = [&](float cells) { return std::floor(cells * r.unit()) / 8; };
  for (int i = 0; i < 700; ++i) {
    const Vec3<float> lo{31.5f + border(16), 31.5f + border(16), 31.5f + border(16)};
    r.boxes.push_back({lo, {lo.x + border(4), lo.y + border(4), lo.z + border(4)}});
  }
  return r.boxes;
}

struct Shape {
  int top, base;
};
constexpr Shape kShapes[] = {{0, 0}, {1, 1}, {0, 2}, {2, 3}, {0, 5}, {4, 7}};

constexpr ListLengths kAmple{1000, 500, 100000, 100000, 500000, 100000};

BoxPairs brute_force(const Boxes& boxes) {
  BoxPairs pairs;
  for (uint32_t a = 0; a < boxes.size(); ++a)
    for (uint32_t b = a + 1; b < boxes.size(); ++b)
      if (overlap(boxes[a], boxes[b])) pairs.emplace_back(a, b);
  return pairs;
}

CellRange cells_of(const OctreeBuild& octree, const Box<float>& box, int level) {
  return shifted(octree.grid.deepest_range(box), kDeepest - level);
}
bool contains(const CellRange& range, const Coords& c) {
  return range.lo.x <= c.x && c.x <= range.hi.x && range.lo.y <= c.y && c.y <= range.hi.y && range.lo.z <= c.z &&
         c.z <= range.hi.z;
}

// A leaf's members are the boxes that overlap its cell, in a place of its own.
void expect_members(OctreeBuild& octree, const Boxes& boxes) {
  std::vector<char> taken(octree.totals[LeafSum::kRegistrations], 0);
  for (uint64_t i = 0; i < octree.totals[LeafSum::kLeaves]; ++i) {
    const Leaf leaf = octree.leaves[i];
    std::vector<uint32_t> members, expected;
    ASSERT_LE(leaf.offset + leaf.count, taken.size());
    for (uint64_t k = leaf.offset; k < leaf.offset + leaf.count; ++k) {
      members.push_back(octree.registered[k]);
      ASSERT_EQ(taken[k]++, 0) << "two leaves in one place";
    }
    for (uint32_t b = 0; b < boxes.size(); ++b)
      if (contains(cells_of(octree, boxes[b], leaf.level), leaf.cell)) expected.push_back(b);
    std::sort(members.begin(), members.end());
    ASSERT_EQ(members, expected) << "leaf " << i << " of level " << leaf.level;
    ASSERT_EQ(octree.cursor[i], leaf.offset + leaf.count);
  }
}

// No leaf lies within another.
void expect_apart(OctreeBuild& octree) {
  using Cell = std::tuple<int, uint32_t, uint32_t, uint32_t>;
  std::set<Cell> cells;
  for (uint64_t i = 0; i < octree.totals[LeafSum::kLeaves]; ++i) {
    const Leaf leaf = octree.leaves[i];
    EXPECT_TRUE(cells.emplace(leaf.level, leaf.cell.x, leaf.cell.y, leaf.cell.z).second) << "the same leaf twice";
  }
  for (auto [level, x, y, z] : cells)
    while (--level >= 0) {
      x >>= 1, y >>= 1, z >>= 1;
      ASSERT_EQ(cells.count({level, x, y, z}), 0u);
    }
}

void expect_totals(OctreeBuild& octree) {
  uint64_t registrations = 0, items = 0, tests = 0;
  for (uint64_t i = 0; i < octree.totals[LeafSum::kLeaves]; ++i) {
    const uint32_t n = octree.leaves[i].count;
    registrations += n, items += items_of(n), tests += tests_of(n);
  }
  EXPECT_EQ(octree.totals[LeafSum::kRegistrations], registrations);
  EXPECT_EQ(octree.totals[LeafSum::kItems], items);
  EXPECT_EQ(octree.totals[LeafSum::kTests], tests);
}

bool fits(const ListLengths& need, const ListLengths& room) {
  const auto n = need.all(), r = room.all();
  return std::equal(n.begin(), n.end(), r.begin(), [](uint64_t a, uint64_t b) { return a <= b; });
}

class Refine : public testing::TestWithParam<std::tuple<Family, int>> {
 protected:
  Boxes boxes(uint32_t seed) const { return std::get<0>(GetParam()).make(seed); }
  int rounds() const { return std::get<1>(GetParam()); }
};

TEST_P(Refine, LeavesHoldWhatOverlapsThemAndFindEveryPairOnce) {
  uint64_t bricks = 0;
  for (const Shape shape : kShapes) {
    SCOPED_TRACE(testing::Message() << "levels " << shape.top << " to " << shape.base);
    const Boxes boxes = this->boxes(static_cast<uint32_t>(shape.base));
    OctreeBuild octree(boxes, shape.top, shape.base, rounds(), kAmple);
    ASSERT_TRUE(fits(octree.need(), kAmple)) << "the test's lists are too short";
    ASSERT_TRUE(octree.is_intact());
    expect_members(octree, boxes);
    expect_apart(octree);
    expect_totals(octree);
    EXPECT_EQ(octree.pairs(), brute_force(boxes));
    bricks += octree.need().bricks;
  }
  EXPECT_EQ(bricks > 0, rounds() > 0) << "nothing was refined";
}

// One list is too short at a time; the others have room for all.
TEST_P(Refine, AListThatIsTooShortTellsWhatItNeeds) {
  const Boxes boxes = this->boxes(7);
  const Shape shape{0, 3};
  const ListLengths need = OctreeBuild(boxes, shape.top, shape.base, rounds(), kAmple).need();
  for (size_t list = 0; list < need.all().size(); ++list)
    for (const uint64_t divisor : {1, 1000000}) {
      uint64_t ListLengths::*const lengths[] = {&ListLengths::large,         &ListLengths::bricks,
                                                &ListLengths::brick_items,   &ListLengths::leaves,
                                                &ListLengths::registrations, &ListLengths::items};
      if (need.*lengths[list] == 0) continue;
      SCOPED_TRACE(testing::Message() << "list " << list << ", need over " << divisor);
      ListLengths room = kAmple;
      room.*lengths[list] = (need.*lengths[list] - 1) / divisor;
      OctreeBuild octree(boxes, shape.top, shape.base, rounds(), room);
      EXPECT_TRUE(octree.is_intact()) << "written out of bounds";
      EXPECT_GT(octree.need().*lengths[list], room.*lengths[list]);
      if (list < 3) continue;  // the lists below depend on these
      EXPECT_EQ(octree.need().all(), need.all()) << "what a list needs does not depend on its length";
    }
}

// What a search reads of a step that will run again.
TEST_P(Refine, ItemsAreSoundWhereListsAreTooShort) {
  const Boxes boxes = this->boxes(8);
  const Shape shape{0, 3};
  const ListLengths need = OctreeBuild(boxes, shape.top, shape.base, rounds(), kAmple).need();
  for (uint64_t ListLengths::*const list : {&ListLengths::large, &ListLengths::bricks, &ListLengths::brick_items,
                                            &ListLengths::leaves, &ListLengths::registrations, &ListLengths::items}) {
    ListLengths room = kAmple;
    room.*list = need.*list / 2;
    OctreeBuild octree(boxes, shape.top, shape.base, rounds(), room);
    EXPECT_TRUE(octree.items_are_sound());
    const bool is_of_leaves =
        list == &ListLengths::leaves || list == &ListLengths::registrations || list == &ListLengths::items;
    if (is_of_leaves && need.*list > 0) {
      EXPECT_TRUE(octree.must_rerun());
    }
  }
}

// Lists that start at nothing and grow to what was asked for, as between the runs of a step.
TEST_P(Refine, ListsGrowToTheirNeedInAFewRuns) {
  const Boxes boxes = this->boxes(9);
  const Shape shape{0, 3};
  ListLengths room{1, 1, 1, 1, 1, 1};
  int runs = 1;
  for (;; ++runs) {
    OctreeBuild octree(boxes, shape.top, shape.base, rounds(), room);
    ASSERT_TRUE(octree.is_intact());
    const ListLengths need = octree.need();
    if (fits(need, room)) {
      EXPECT_EQ(octree.pairs(), brute_force(boxes));
      break;
    }
    ASSERT_LE(runs, 2 * kMaxRounds + 2);  // each round may lack bricks, then room for their triangles
    const auto grow = [](uint64_t& have, uint64_t wanted) { have = std::max(have, wanted); };
    grow(room.large, need.large), grow(room.bricks, need.bricks), grow(room.brick_items, need.brick_items);
    grow(room.leaves, need.leaves);
    grow(room.registrations, need.registrations), grow(room.items, need.items);
  }
}

INSTANTIATE_TEST_SUITE_P(Boxes, Refine,
                         testing::Combine(testing::Values(Family{"ClustersInClusters", clusters_in_clusters},
                                                          Family{"ClustersApart", clusters_apart},
                                                          Family{"UnderHugeBoxes", clusters_under_huge_boxes},
                                                          Family{"InOnePoint", in_one_point},
                                                          Family{"OnBorders", on_borders}),
                                          testing::Range(0, kMaxRounds + 1)),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).name) + std::to_string(std::get<1>(info.param));
                         });

}  // namespace
}  // namespace collided::test
